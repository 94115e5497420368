#include <earpoint/core/atomic_folder.h>

#include <string>
#include <system_error>
#include <utility>

#include <earpoint/error.h>

namespace earpoint {

namespace fs = std::filesystem;

AtomicFolder::AtomicFolder(fs::path path) : path_(std::move(path)) {
  aside_ = path_.parent_path() / ("." + path_.filename().string() + ".partial");
  std::error_code error;
  fs::remove_all(aside_, error);  // of a run that was killed
  fs::create_directories(aside_, error);
  if (error) throw InputError(path_.string(), "cannot be created: " + error.message());
}

AtomicFolder::~AtomicFolder() {
  if (committed_) return;
  std::error_code ignored;
  fs::remove_all(aside_, ignored);
}

void AtomicFolder::commit() {
  std::error_code error;
  fs::remove_all(path_, error);  // it lacked a file
  fs::rename(aside_, path_, error);
  if (error) throw InputError(path_.string(), "cannot be created: " + error.message());
  committed_ = true;
}

}  // namespace earpoint
