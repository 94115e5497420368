#include <earpoint/weights/safetensors.h>

#include "safetensors_header.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/core/quote.h>
#include <earpoint/error.h>

namespace earpoint {
namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kLengthSize = 8;
constexpr std::int64_t kLargestHeader = 100'000'000;  // as in the reference implementation

/// The first 8 bytes, checked: a length is believed only when the file has that many bytes.
std::int64_t checked_header_length(std::span<const std::byte> first, std::int64_t file_size,
                                   std::string_view where) {
  if (file_size < kLengthSize) {
    throw InputError(where,
                     fmt::format("has {} bytes, too short for a safetensors file", file_size),
                     "was it copied completely?");
  }
  std::uint64_t length = 0;
  std::memcpy(&length, first.data(), sizeof(length));
  if (length > std::uint64_t{kLargestHeader}) {
    throw InputError(
        where, fmt::format("claims a header of {} bytes, more than {}", length, kLargestHeader),
        "is this a safetensors file?");
  }
  if (static_cast<std::int64_t>(length) > file_size - kLengthSize) {
    throw InputError(where,
                     fmt::format("claims a header of {} bytes, but only {} follow", length,
                                 file_size - kLengthSize),
                     "was it copied completely?");
  }
  return static_cast<std::int64_t>(length);
}

/// Fills every tensor by `read(begin, bytes)`, in the order of the data.
template <typename Read>
SafetensorsFile fill_tensors(SafetensorsHeader header, std::string_view where, const Read& read) {
  using Entry = std::pair<const std::string, SafetensorsEntry>;
  std::vector<Entry*> in_order;
  in_order.reserve(header.entries.size());
  for (Entry& entry : header.entries) in_order.push_back(&entry);
  std::sort(in_order.begin(), in_order.end(),
            [](const Entry* a, const Entry* b) { return a->second.begin < b->second.begin; });

  SafetensorsFile file;
  file.metadata = std::move(header.metadata);
  for (Entry* entry : in_order) {
    auto& [name, facts] = *entry;
    Tensor tensor{facts.dtype, std::move(facts.shape), {}};
    tensor.data.resize(static_cast<std::size_t>(facts.end - facts.begin));
    read(facts.begin, std::span(tensor.data));
    if (tensor.dtype == DType::boolean &&
        std::any_of(tensor.data.begin(), tensor.data.end(),
                    [](std::byte b) { return b > std::byte{1}; })) {
      throw InputError(fmt::format("{}: tensor {}", where, in_quotes(name)),
                       "is of type BOOL but has bytes other than 0 and 1");
    }
    file.tensors.emplace(name, std::move(tensor));
  }
  return file;
}

void read_exactly(std::ifstream& stream, std::span<std::byte> bytes, const fs::path& path) {
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (stream.gcount() != static_cast<std::streamsize>(bytes.size())) {
    throw InputError(path.string(), "could not be read completely");
  }
}

/// The JSON object without padding; offsets follow `order`.
std::string compose_header(const SafetensorsFile& file,
                           const std::vector<const std::string*>& order) {
  std::map<std::string_view, std::pair<std::size_t, std::size_t>> offsets;
  std::size_t covered = 0;
  for (const std::string* name : order) {
    const std::size_t size = file.tensors.at(*name).data.size();
    offsets[*name] = {covered, covered + size};
    covered += size;
  }
  // nlohmann's object is a sorted map: "__metadata__" stands where its name puts it.
  nlohmann::json header = nlohmann::json::object();
  if (!file.metadata.empty()) header["__metadata__"] = file.metadata;
  for (const auto& [name, tensor] : file.tensors) {
    const auto [begin, end] = offsets[name];
    header[name] = {
        {"dtype", name_of(tensor.dtype)}, {"shape", tensor.shape}, {"data_offsets", {begin, end}}};
  }
  return header.dump();
}

}  // namespace

SafetensorsFile parse_safetensors(std::span<const std::byte> bytes, std::string_view where) {
  const auto size = static_cast<std::int64_t>(bytes.size());
  const std::int64_t length = checked_header_length(bytes, size, where);
  const auto header_bytes = bytes.subspan(kLengthSize, static_cast<std::size_t>(length));
  const auto data = bytes.subspan(static_cast<std::size_t>(kLengthSize + length));
  const std::string_view text(reinterpret_cast<const char*>(header_bytes.data()),
                              header_bytes.size());
  return fill_tensors(parse_safetensors_header(text, static_cast<std::int64_t>(data.size()), where),
                      where, [data](std::int64_t begin, std::span<std::byte> to) {
                        std::copy_n(data.begin() + begin, to.size(), to.begin());
                      });
}

SafetensorsFile read_safetensors(const fs::path& path) {
  const std::string where = path.string();
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError(where, "no such file");
  if (!fs::is_regular_file(status)) throw InputError(where, "is not a file");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw InputError(where,
                     fmt::format("cannot be opened ({})", std::generic_category().message(errno)));
  }
  const auto size = static_cast<std::int64_t>(fs::file_size(path));

  std::vector<std::byte> first(static_cast<std::size_t>(std::min(size, kLengthSize)));
  read_exactly(stream, first, path);
  const std::int64_t length = checked_header_length(first, size, where);
  std::string text(static_cast<std::size_t>(length), '\0');
  read_exactly(stream, std::as_writable_bytes(std::span(text)), path);

  // Without gaps and in order, the data are one run: no seeking.
  return fill_tensors(
      parse_safetensors_header(text, size - kLengthSize - length, where), where,
      [&](std::int64_t /*begin*/, std::span<std::byte> to) { read_exactly(stream, to, path); });
}

std::vector<std::byte> serialize_safetensors(const SafetensorsFile& file, std::string_view where) {
  if (file.tensors.contains("__metadata__")) {
    throw InputError(where, "a tensor cannot be named '__metadata__'");
  }
  std::vector<const std::string*> order;
  std::size_t data_size = 0;
  for (const auto& [name, tensor] : file.tensors) {
    EARPOINT_CHECK(tensor.data.size() ==
                   static_cast<std::size_t>(tensor.elements()) * size_of(tensor.dtype));
    order.push_back(&name);
    data_size += tensor.data.size();
  }
  std::stable_sort(order.begin(), order.end(), [&](const std::string* a, const std::string* b) {
    return size_of(file.tensors.at(*a).dtype) > size_of(file.tensors.at(*b).dtype);
  });

  std::string header;
  try {
    header = compose_header(file, order);
  } catch (const nlohmann::json::type_error&) {
    throw InputError(where, "a tensor's name or the metadata are not UTF-8");
  }
  header.resize((header.size() + 7) / 8 * 8, ' ');

  std::vector<std::byte> bytes(kLengthSize + header.size());
  bytes.reserve(bytes.size() + data_size);
  const std::uint64_t length = header.size();
  std::memcpy(bytes.data(), &length, sizeof(length));
  std::memcpy(bytes.data() + kLengthSize, header.data(), header.size());
  for (const std::string* name : order) {
    const std::vector<std::byte>& data = file.tensors.at(*name).data;
    bytes.insert(bytes.end(), data.begin(), data.end());
  }
  return bytes;
}

void write_safetensors(const fs::path& path, const SafetensorsFile& file) {
  write_file(path, serialize_safetensors(file, path.string()));
}

const Tensor& expect_tensor(const SafetensorsFile& file, std::string_view where,
                            const std::string& name, DType dtype,
                            std::initializer_list<std::int64_t> shape) {
  const auto found = file.tensors.find(name);
  if (found == file.tensors.end()) {
    throw InputError(where, fmt::format("has no tensor {}", in_quotes(name)));
  }
  const Tensor& tensor = found->second;
  const bool fits = std::equal(tensor.shape.begin(), tensor.shape.end(), shape.begin(), shape.end(),
                               [](std::int64_t size, std::int64_t expected) {
                                 return expected == kAnySize || size == expected;
                               });
  if (tensor.dtype != dtype || !fits) {
    std::string expected = to_string(std::vector<std::int64_t>(shape));
    for (std::size_t at = 0; (at = expected.find("-1", at)) != std::string::npos;) {
      expected.replace(at, 2, "any");
    }
    throw InputError(fmt::format("{}: tensor {}", where, in_quotes(name)),
                     fmt::format("expected {} {}, found {} {}", name_of(dtype), expected,
                                 name_of(tensor.dtype), to_string(tensor.shape)));
  }
  return tensor;
}

}  // namespace earpoint
