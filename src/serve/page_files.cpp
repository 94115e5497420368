#include "page_files.h"

#include "page_bytes.h"

#include <earpoint/serve/clip_server.h>

namespace earpoint {
namespace {

const char* type_of(std::string_view name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  return "application/octet-stream";
}

}  // namespace

bool has_page() { return !page_bytes().empty(); }

std::optional<PageFile> page_file(std::string_view path) {
  if (!path.starts_with('/')) return std::nullopt;
  const std::string_view name = path == "/" ? std::string_view("index.html") : path.substr(1);
  for (const PageBytes& file : page_bytes()) {
    if (file.name == name) return PageFile{file.bytes, type_of(name)};
  }
  return std::nullopt;
}

}  // namespace earpoint
