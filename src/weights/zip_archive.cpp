#include <earpoint/weights/zip_archive.h>

#include "utf8.h"

#include <system_error>

#include <fmt/format.h>
#include <zip.h>

#include <earpoint/core/quote.h>
#include <earpoint/error.h>

namespace earpoint {
namespace fs = std::filesystem;

namespace {

[[noreturn]] void throw_zip_error(std::string_view where, zip_error_t& error) {
  const std::string text = zip_error_strerror(&error);
  zip_error_fini(&error);
  throw InputError(where, fmt::format("is not a complete zip archive ({})", text),
                   "is it a checkpoint of PyTorch 1.6 or newer, copied completely?");
}

zip_t* open_source(zip_source_t* source, zip_error_t& error, std::string_view where) {
  if (source == nullptr) throw_zip_error(where, error);
  zip_t* archive = zip_open_from_source(source, ZIP_RDONLY, &error);
  if (archive == nullptr) {
    zip_source_free(source);
    throw_zip_error(where, error);
  }
  zip_error_fini(&error);
  return archive;
}

}  // namespace

void ZipArchive::Close::operator()(zip* archive) const { zip_discard(archive); }

ZipArchive::ZipArchive(const fs::path& path) : where_(path.string()) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (!fs::exists(status)) throw InputError(where_, "no such file");
  if (!fs::is_regular_file(status)) throw InputError(where_, "is not a file");
  file_size_ = fs::file_size(path);
  zip_error_t error;
  zip_error_init(&error);
  archive_.reset(open_source(zip_source_file_create(path.c_str(), 0, -1, &error), error, where_));
  list_members();
}

ZipArchive::ZipArchive(std::span<const std::byte> bytes, std::string_view where)
    : where_(where), file_size_(bytes.size()) {
  zip_error_t error;
  zip_error_init(&error);
  archive_.reset(
      open_source(zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error), error, where_));
  list_members();
}

void ZipArchive::list_members() {
  // The library takes no bytes for an archive without members.
  if (file_size_ == 0) throw InputError(where_, "is empty");
  const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
  std::uint64_t total = 0;
  for (zip_int64_t i = 0; i < count; ++i) {
    zip_stat_t stat;
    zip_stat_init(&stat);
    constexpr zip_uint64_t kNeeded = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE |
                                     ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
    if (zip_stat_index(archive_.get(), static_cast<zip_uint64_t>(i), ZIP_FL_ENC_RAW, &stat) != 0 ||
        (stat.valid & kNeeded) != kNeeded) {
      throw InputError(
          where_, fmt::format("member {} cannot be read ({})", i, zip_strerror(archive_.get())));
    }
    const std::string name = stat.name;
    const std::string where = fmt::format("{}: member {}", where_, in_quotes(name));
    if (!is_utf8(name))
      throw InputError(where_, fmt::format("the name of member {} is not UTF-8", i));
    if (stat.comp_method != ZIP_CM_STORE || stat.encryption_method != ZIP_EM_NONE ||
        stat.comp_size != stat.size) {
      throw InputError(where, "is compressed or encrypted",
                       "PyTorch stores its members uncompressed; was the archive repacked?");
    }
    if (__builtin_add_overflow(total, stat.size, &total) || total > file_size_) {
      throw InputError(where, "overlaps others or is larger than the file");
    }
    if (!sizes_.emplace(name, stat.size).second) throw InputError(where, "occurs twice");
    indices_.emplace(name, static_cast<std::uint64_t>(i));
  }
}

std::vector<std::byte> ZipArchive::read(const std::string& name) const {
  const auto size = sizes_.find(name);
  if (size == sizes_.end()) {
    throw InputError(where_, fmt::format("has no member {}", in_quotes(name)));
  }
  const std::string where = fmt::format("{}: member {}", where_, in_quotes(name));
  const auto close = [](zip_file_t* file) { zip_fclose(file); };
  const std::unique_ptr<zip_file_t, decltype(close)> file(
      zip_fopen_index(archive_.get(), indices_.at(name), 0), close);
  if (file == nullptr) {
    throw InputError(where, fmt::format("cannot be read ({})", zip_strerror(archive_.get())));
  }
  std::vector<std::byte> bytes(size->second);
  std::uint64_t filled = 0;
  while (filled < bytes.size()) {
    const zip_int64_t got = zip_fread(file.get(), bytes.data() + filled, bytes.size() - filled);
    if (got <= 0) {
      throw InputError(
          where, fmt::format("cannot be read to its end ({})", zip_file_strerror(file.get())));
    }
    filled += static_cast<std::uint64_t>(got);
  }
  // The checksum is compared when the end is met.
  std::byte beyond{};
  if (zip_fread(file.get(), &beyond, 1) != 0) {
    throw InputError(where, fmt::format("is damaged ({})", zip_file_strerror(file.get())));
  }
  return bytes;
}

}  // namespace earpoint
