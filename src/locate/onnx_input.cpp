#include "onnx_input.h"

#include <cstdint>
#include <vector>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

using Bytes = std::span<const std::byte>;

// Field numbers of onnx.proto.
constexpr std::uint64_t kGraph = 7;          // of ModelProto
constexpr std::uint64_t kInput = 11;         // of GraphProto
constexpr std::uint64_t kType = 2;           // of ValueInfoProto
constexpr std::uint64_t kTensorType = 1;     // of TypeProto
constexpr std::uint64_t kShape = 2;          // of TypeProto.Tensor
constexpr std::uint64_t kDimension = 1;      // of TensorShapeProto
constexpr std::uint64_t kDimensionSize = 1;  // of TensorShapeProto.Dimension

constexpr std::uint64_t kMostPixels = 8192;

/// One field of a protobuf message.
struct Field {
  std::uint64_t number = 0;
  std::uint64_t value = 0;  ///< of a number
  Bytes bytes;              ///< of a message or text
};

/// Takes a message apart, field by field.
class MessageReader {
 public:
  MessageReader(Bytes bytes, std::string_view where) : bytes_(bytes), where_(where) {}

  /// @return nothing at the end
  std::optional<Field> next() {
    if (bytes_.empty()) return std::nullopt;
    const std::uint64_t key = number();
    Field field{key >> 3U, 0, {}};
    switch (key & 7U) {
      case 0:
        field.value = number();
        break;
      case 1:
        (void)take(8);
        break;
      case 2:
        field.bytes = take(number());
        break;
      case 5:
        (void)take(4);
        break;
      default:
        fail();
    }
    return field;
  }

 private:
  std::uint64_t number() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const auto byte = std::to_integer<std::uint64_t>(take(1)[0]);
      value |= (byte & 0x7FU) << shift;
      if (byte < 0x80U) return value;
    }
    fail();
  }

  Bytes take(std::uint64_t count) {
    if (count > bytes_.size()) fail();
    const Bytes taken = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return taken;
  }

  [[noreturn]] void fail() const { throw InputError(std::string(where_), "is not an ONNX file"); }

  Bytes bytes_;
  std::string_view where_;
};

std::vector<Bytes> parts(Bytes message, std::uint64_t number, std::string_view where) {
  std::vector<Bytes> found;
  MessageReader reader(message, where);
  while (const auto field = reader.next()) {
    if (field->number == number) found.push_back(field->bytes);
  }
  return found;
}

/// The first part at the end of a path of field numbers; empty if there is none.
Bytes part_at(Bytes message, std::initializer_list<std::uint64_t> path, std::string_view where) {
  for (const std::uint64_t number : path) {
    const std::vector<Bytes> found = parts(message, number, where);
    if (found.empty()) return {};
    message = found.front();
  }
  return message;
}

/// Sizes along each axis; 0 where it is left open.
std::vector<std::uint64_t> shape_of(Bytes input, std::string_view where) {
  std::vector<std::uint64_t> shape;
  for (const Bytes dimension :
       parts(part_at(input, {kType, kTensorType, kShape}, where), kDimension, where)) {
    std::uint64_t size = 0;
    MessageReader reader(dimension, where);
    while (const auto field = reader.next()) {
      if (field->number == kDimensionSize) size = field->value;
    }
    shape.push_back(size);
  }
  return shape;
}

}  // namespace

std::optional<OnnxInput> onnx_input(Bytes bytes, std::string_view where) {
  for (const Bytes input : parts(part_at(bytes, {kGraph}, where), kInput, where)) {
    const std::vector<std::uint64_t> shape = shape_of(input, where);
    if (shape.size() != 4 || shape[1] != 3) continue;
    if (shape[2] == 0 || shape[3] == 0) return std::nullopt;
    if (shape[2] > kMostPixels || shape[3] > kMostPixels) {
      throw InputError(std::string(where),
                       fmt::format("takes pictures of {} x {} pixels; expected at most {}",
                                   shape[3], shape[2], kMostPixels));
    }
    return OnnxInput{static_cast<int>(shape[2]), static_cast<int>(shape[3])};
  }
  throw InputError(std::string(where), "is not an ONNX network for pictures of three channels",
                   "give a YOLOX or YOLOv8 detector");
}

}  // namespace earpoint
