#include "stored_tensor.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/quote.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

using Kind = PickleValue::Kind;

constexpr std::size_t kMostAxes = 64;  // as many as PyTorch allows

struct StorageType {
  std::string_view name;
  DType dtype;
};

constexpr std::array<StorageType, 10> kStorageTypes{{{"FloatStorage", DType::f32},
                                                     {"DoubleStorage", DType::f64},
                                                     {"HalfStorage", DType::f16},
                                                     {"BFloat16Storage", DType::bf16},
                                                     {"LongStorage", DType::i64},
                                                     {"IntStorage", DType::i32},
                                                     {"ShortStorage", DType::i16},
                                                     {"CharStorage", DType::i8},
                                                     {"ByteStorage", DType::u8},
                                                     {"BoolStorage", DType::boolean}}};

[[noreturn]] void fail(std::string_view where, std::string_view problem) {
  throw InputError(where, problem);
}

/// What a value is, for messages.
std::string kind_of(const PickleValue& value) {
  switch (value.kind) {
    case Kind::none:
      return "nothing";
    case Kind::boolean:
      return "a boolean";
    case Kind::integer:
    case Kind::big_integer:
      return "an integer";
    case Kind::real:
      return "a number";
    case Kind::string:
      return "a string";
    case Kind::bytes:
      return "bytes";
    case Kind::list:
      return "a list";
    case Kind::tuple:
      return "a tuple";
    case Kind::set:
      return "a set";
    case Kind::dict:
      return "a dictionary";
    case Kind::persistent_id:
      return "a storage";
    case Kind::global:
      return fmt::format("the class {}", in_quotes(fmt::format("{}.{}", value.items[0]->text,
                                                               value.items[1]->text)));
    case Kind::object: {
      const PickleValue& made_by = *value.items[PickleValue::kCallable];
      return made_by.kind == Kind::global ? "an object of " + kind_of(made_by) : "an object";
    }
  }
  return "a value";
}

std::int64_t count_from(const PickleValue& value, std::string_view what, std::string_view where) {
  if (value.kind != Kind::integer) {
    fail(where, fmt::format("{}: expected an integer, found {}", what, kind_of(value)));
  }
  if (value.integer < 0) fail(where, fmt::format("{} is negative: {}", what, value.integer));
  return value.integer;
}

std::vector<std::int64_t> counts_from(const PickleValue& value, std::string_view what,
                                      std::string_view where) {
  if (value.kind != Kind::tuple || value.items.size() > kMostAxes) {
    fail(where, fmt::format("{}: expected a tuple of at most {} integers, found {}", what,
                            kMostAxes, kind_of(value)));
  }
  std::vector<std::int64_t> counts;
  for (const PickleValue* item : value.items) counts.push_back(count_from(*item, what, where));
  return counts;
}

/// The persistent id ('storage', class, key, location, elements).
void read_storage(const PickleValue& value, StoredTensor& tensor, std::string_view where) {
  const bool is_id = value.kind == Kind::persistent_id && value.items[0]->kind == Kind::tuple &&
                     value.items[0]->items.size() >= 5;
  if (!is_id) fail(where, fmt::format("expected a storage, found {}", kind_of(value)));
  const auto& id = value.items[0]->items;
  if (id[0]->kind != Kind::string || id[0]->text != "storage" || id[2]->kind != Kind::string) {
    fail(where, "its storage is not named like PyTorch's");
  }
  const auto type =
      std::find_if(kStorageTypes.begin(), kStorageTypes.end(),
                   [&](const StorageType& t) { return id[1]->is_global("torch", t.name); });
  if (type == kStorageTypes.end()) {
    fail(where, fmt::format("its storage has an unknown type: {}", kind_of(*id[1])));
  }
  tensor.dtype = type->dtype;
  tensor.storage_key = id[2]->text;
  tensor.storage_elements = count_from(*id[4], "number of stored elements", where);
}

/// Every element's index must lie inside of the storage.
void check_extent(const StoredTensor& tensor, std::string_view where) {
  const auto count = element_count(tensor.shape);
  std::int64_t bytes = 0;
  if (!count || __builtin_mul_overflow(*count, std::int64_t{8}, &bytes)) {
    fail(where, fmt::format("size {} is too large", to_string(tensor.shape)));
  }
  if (*count == 0) return;
  std::int64_t last = tensor.offset;
  bool overflow = false;
  for (std::size_t axis = 0; axis < tensor.shape.size(); ++axis) {
    std::int64_t reach = 0;
    overflow = __builtin_mul_overflow(tensor.shape[axis] - 1, tensor.strides[axis], &reach) ||
               __builtin_add_overflow(last, reach, &last) || overflow;
  }
  if (overflow || last >= tensor.storage_elements) {
    fail(where, fmt::format("offset {}, size {} and stride {} leave the storage of {} elements",
                            tensor.offset, to_string(tensor.shape), to_string(tensor.strides),
                            tensor.storage_elements));
  }
}

bool is_contiguous(const StoredTensor& tensor) {
  std::int64_t expected = 1;
  for (std::size_t axis = tensor.shape.size(); axis-- > 0;) {
    if (tensor.shape[axis] != 1 && tensor.strides[axis] != expected) return false;
    expected *= tensor.shape[axis];
  }
  return true;
}

/// Element by element in row-major order; the index runs like an odometer.
void copy_strided(const StoredTensor& stored, const std::byte* from, std::vector<std::byte>& to) {
  const std::size_t size = size_of(stored.dtype);
  std::vector<std::int64_t> index(stored.shape.size(), 0);
  std::int64_t element = stored.offset;
  for (std::size_t i = 0; i < to.size(); i += size) {
    std::memcpy(to.data() + i, from + static_cast<std::size_t>(element) * size, size);
    for (std::size_t axis = index.size(); axis-- > 0;) {
      element += stored.strides[axis];
      if (++index[axis] < stored.shape[axis]) break;
      element -= stored.strides[axis] * stored.shape[axis];
      index[axis] = 0;
    }
  }
}

}  // namespace

std::uint64_t StoredTensor::size_bytes() const {
  return static_cast<std::uint64_t>(element_count(shape).value()) * size_of(dtype);
}

StoredTensor stored_tensor_from(const PickleValue& value, std::string_view where) {
  const PickleValue* tensor = &value;
  if (value.is_made_by("torch._utils", "_rebuild_parameter") && !value.arguments().items.empty()) {
    tensor = value.arguments().items[0];
  }
  if (!tensor->is_made_by("torch._utils", "_rebuild_tensor_v2") &&
      !tensor->is_made_by("torch._utils", "_rebuild_tensor")) {
    fail(where, fmt::format("expected a tensor, found {}", kind_of(*tensor)));
  }
  const auto& arguments = tensor->arguments().items;
  if (arguments.size() < 4) {
    fail(where, fmt::format("a tensor has at least 4 properties, found {}", arguments.size()));
  }
  StoredTensor stored;
  read_storage(*arguments[0], stored, where);
  stored.offset = count_from(*arguments[1], "offset", where);
  stored.shape = counts_from(*arguments[2], "size", where);
  stored.strides = counts_from(*arguments[3], "stride", where);
  if (stored.shape.size() != stored.strides.size()) {
    fail(where, fmt::format("size {} and stride {} have different lengths", to_string(stored.shape),
                            to_string(stored.strides)));
  }
  check_extent(stored, where);
  return stored;
}

Tensor extract_tensor(const StoredTensor& stored, std::span<const std::byte> storage,
                      std::string_view where) {
  const std::size_t size = size_of(stored.dtype);
  if (storage.size() % size != 0 ||
      storage.size() / size != static_cast<std::uint64_t>(stored.storage_elements)) {
    fail(where, fmt::format("expected a storage of {} elements of {} bytes, found {} bytes",
                            stored.storage_elements, size, storage.size()));
  }
  Tensor tensor{stored.dtype, stored.shape, {}};
  if (is_contiguous(stored) && stored.size_bytes() > 0) {
    const auto part =
        storage.subspan(static_cast<std::size_t>(stored.offset) * size, stored.size_bytes());
    tensor.data.assign(part.begin(), part.end());
  } else {
    tensor.data.resize(stored.size_bytes());
    copy_strided(stored, storage.data(), tensor.data);
  }
  if (stored.dtype == DType::boolean && std::any_of(tensor.data.begin(), tensor.data.end(),
                                                    [](std::byte b) { return b > std::byte{1}; })) {
    fail(where, "is of booleans but has bytes other than 0 and 1");
  }
  return tensor;
}

}  // namespace earpoint
