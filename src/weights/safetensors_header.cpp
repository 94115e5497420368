#include "safetensors_header.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/quote.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kMetadataKey = "__metadata__";

/// Takes the header apart while it is parsed. A tree of it is never built: a tree would accept
/// duplicate keys, and a hostile header could make it many times as large as the file.
class HeaderReader : public nlohmann::json_sax<Json> {
 public:
  explicit HeaderReader(std::string_view where) : where_(where) {}

  [[nodiscard]] SafetensorsHeader take() { return std::move(header_); }

  bool null() override { reject("null"); }
  bool boolean(bool /*value*/) override { reject("a boolean"); }
  bool number_integer(number_integer_t value) override {
    reject(fmt::format("the negative number {}", value));
  }
  bool number_unsigned(number_unsigned_t value) override {
    std::vector<std::int64_t>* list = field_ == "shape"          ? &shape_
                                      : field_ == "data_offsets" ? &offsets_
                                                                 : nullptr;
    if (place_ != Place::list || list == nullptr) reject(fmt::format("the number {}", value));
    if (value > std::uint64_t{std::numeric_limits<std::int64_t>::max()}) {
      reject(fmt::format("the number {}", value));
    }
    list->push_back(static_cast<std::int64_t>(value));
    return true;
  }
  bool number_float(number_float_t /*value*/, const string_t& text) override {
    reject("the number " + text.substr(0, 40));
  }
  bool string(string_t& value) override {
    if (place_ == Place::metadata) {
      if (!header_.metadata.try_emplace(field_, std::move(value)).second) {
        fail(fmt::format("key {} occurs twice", in_quotes(field_)));
      }
      return true;
    }
    if (place_ != Place::entry || field_ != "dtype") reject("the string " + in_quotes(value));
    dtype_ = dtype_from_name(value);
    if (!dtype_) fail("unknown dtype " + in_quotes(value));
    return true;
  }
  bool binary(binary_t& /*value*/) override { reject("binary"); }

  bool start_object(std::size_t /*elements*/) override {
    if (place_ == Place::start) {
      place_ = Place::top;
    } else if (place_ == Place::top) {
      place_ = name_ == kMetadataKey ? Place::metadata : Place::entry;
      field_.clear();
      dtype_.reset();
      shape_seen_ = offsets_seen_ = false;
    } else {
      reject("an object");
    }
    return true;
  }
  bool key(string_t& value) override {
    if (place_ == Place::top) {
      name_ = std::move(value);
      const bool seen_metadata = name_ == kMetadataKey && std::exchange(metadata_seen_, true);
      if (seen_metadata || header_.entries.contains(name_)) fail("occurs twice in the header");
      return true;
    }
    field_ = std::move(value);
    if (place_ == Place::metadata) return true;
    bool seen = false;
    if (field_ == "dtype") {
      seen = dtype_.has_value();
    } else if (field_ == "shape") {
      seen = std::exchange(shape_seen_, true);
    } else if (field_ == "data_offsets") {
      seen = std::exchange(offsets_seen_, true);
    } else {
      fail("unknown key " + in_quotes(field_));
    }
    if (seen) fail(fmt::format("key {} occurs twice", in_quotes(field_)));
    return true;
  }
  bool end_object() override {
    if (place_ == Place::entry) finish_entry();
    place_ = place_ == Place::top ? Place::done : Place::top;
    return true;
  }
  bool start_array(std::size_t /*elements*/) override {
    if (place_ != Place::entry || (field_ != "shape" && field_ != "data_offsets")) reject("a list");
    (field_ == "shape" ? shape_ : offsets_).clear();
    place_ = Place::list;
    return true;
  }
  bool end_array() override {
    place_ = Place::entry;
    return true;
  }
  bool parse_error(std::size_t position, const std::string& /*last_token*/,
                   const nlohmann::detail::exception& /*error*/) override {
    throw InputError(where_, fmt::format("the header is not valid JSON at byte {}", position),
                     "is this a safetensors file, copied completely?");
  }

 private:
  enum class Place { start, top, metadata, entry, list, done };

  [[noreturn]] void fail(std::string_view problem) const {
    throw InputError(name_.empty() && place_ == Place::start
                         ? where_
                         : fmt::format("{}: tensor {}", where_, in_quotes(name_)),
                     problem);
  }

  [[noreturn]] void reject(std::string_view found) const {
    const std::string_view expected = place_ == Place::start      ? "an object"
                                      : place_ == Place::top      ? "an object per tensor"
                                      : place_ == Place::metadata ? "a string"
                                      : field_ == "dtype"         ? "a string"
                                                                  : "a list of integers >= 0";
    const std::string field =
        place_ == Place::start || place_ == Place::top ? std::string("header") : in_quotes(field_);
    fail(fmt::format("{}: expected {}, found {}", field, expected, found));
  }

  void finish_entry() {
    if (!dtype_) fail("has no \"dtype\"");
    if (!shape_seen_) fail("has no \"shape\"");
    if (!offsets_seen_) fail("has no \"data_offsets\"");
    if (offsets_.size() != 2) {
      fail(fmt::format("\"data_offsets\": expected 2 numbers, found {}", offsets_.size()));
    }
    header_.entries.emplace(name_, SafetensorsEntry{*dtype_, shape_, offsets_[0], offsets_[1]});
  }

  std::string where_;
  SafetensorsHeader header_;
  Place place_ = Place::start;
  bool metadata_seen_ = false;
  std::string name_;   ///< of the tensor, or "__metadata__"
  std::string field_;  ///< key inside it
  std::optional<DType> dtype_;
  std::vector<std::int64_t> shape_;
  std::vector<std::int64_t> offsets_;
  bool shape_seen_ = false;
  bool offsets_seen_ = false;
};

void check_entry(const SafetensorsEntry& entry, std::int64_t data_size, std::string_view where) {
  if (entry.begin > entry.end || entry.end > data_size) {
    throw InputError(where, fmt::format("data_offsets [{}, {}] leave the {} bytes of data",
                                        entry.begin, entry.end, data_size));
  }
  const std::optional<std::int64_t> count = element_count(entry.shape);
  const auto element_size = static_cast<std::int64_t>(size_of(entry.dtype));
  std::int64_t size = 0;
  if (!count || __builtin_mul_overflow(*count, element_size, &size)) {
    throw InputError(where, fmt::format("shape {} is too large", to_string(entry.shape)));
  }
  if (size != entry.end - entry.begin) {
    throw InputError(where,
                     fmt::format("shape {} of {} needs {} bytes, data_offsets [{}, {}] hold {}",
                                 to_string(entry.shape), name_of(entry.dtype), size, entry.begin,
                                 entry.end, entry.end - entry.begin));
  }
}

/// No byte of the data may belong to two tensors or to none.
void check_coverage(const SafetensorsHeader& header, std::int64_t data_size,
                    std::string_view where) {
  std::vector<const std::pair<const std::string, SafetensorsEntry>*> in_order;
  in_order.reserve(header.entries.size());
  for (const auto& entry : header.entries) in_order.push_back(&entry);
  std::sort(in_order.begin(), in_order.end(), [](const auto* a, const auto* b) {
    return std::pair(a->second.begin, a->second.end) < std::pair(b->second.begin, b->second.end);
  });
  std::int64_t covered = 0;
  for (const auto* entry : in_order) {
    if (entry->second.begin != covered) {
      throw InputError(
          fmt::format("{}: tensor {}", where, in_quotes(entry->first)),
          fmt::format("its data start at byte {}, {} byte {}", entry->second.begin,
                      entry->second.begin < covered ? "inside another tensor that ends at"
                                                    : "after a gap that starts at",
                      covered));
    }
    covered = entry->second.end;
  }
  if (covered != data_size) {
    throw InputError(
        where, fmt::format("the tensors end at byte {} of {} bytes of data", covered, data_size));
  }
}

}  // namespace

SafetensorsHeader parse_safetensors_header(std::string_view text, std::int64_t data_size,
                                           std::string_view where) {
  // The parser takes a NUL for the end and skips a byte order mark; the format has neither.
  if (text.empty() || text.front() != '{' || text.find('\0') != std::string_view::npos) {
    throw InputError(where, "the header is not a JSON object", "is this a safetensors file?");
  }
  HeaderReader reader(where);
  Json::sax_parse(text.begin(), text.end(), &reader);
  SafetensorsHeader header = reader.take();
  for (const auto& [name, entry] : header.entries) {
    check_entry(entry, data_size, fmt::format("{}: tensor {}", where, in_quotes(name)));
  }
  check_coverage(header, data_size, where);
  return header;
}

}  // namespace earpoint
