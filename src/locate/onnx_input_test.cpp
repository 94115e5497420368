#include "onnx_input.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

const std::string kData = EARPOINT_SOURCE_DIR "/src/locate/testdata/";

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

TEST(OnnxInput, IsTheShapeThatTheFileGives) {
  const auto input = onnx_input(read_file(kData + "yolox.onnx"), "x");
  ASSERT_TRUE(input.has_value());
  EXPECT_EQ(input->height, 64);
  EXPECT_EQ(input->width, 64);
}

TEST(OnnxInput, IsUnknownWhereASideIsLeftOpen) {
  // graph { input { type { tensor_type { shape { dim 1, dim 3, dim "h", dim "w" } } } } }
  const auto open =
      bytes_of({0x3A, 26, 0x5A, 24, 0x12, 22, 0x0A, 20, 0x12, 18,   0x0A, 2,    0x08, 1,
                0x0A, 2,  0x08, 3,  0x0A, 3,  0x12, 1,  'h',  0x0A, 3,    0x12, 1,    'w'});
  EXPECT_FALSE(onnx_input(open, "x").has_value());
}

TEST(OnnxInput, OtherFilesAreRefused) {
  EXPECT_THROW((void)onnx_input({}, "x"), InputError);
  EXPECT_THROW((void)onnx_input(bytes_of({0x3A, 100, 1}), "x"), InputError);  // cut short
  EXPECT_THROW((void)onnx_input(bytes_of({0x3B}), "x"), InputError);          // no such kind
  std::vector<std::byte> half = read_file(kData + "yolov8.onnx");
  half.resize(half.size() / 2);
  EXPECT_THROW((void)onnx_input(half, "x"), InputError);
}

}  // namespace
}  // namespace earpoint
