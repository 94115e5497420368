#include <earpoint/render/head_file.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/weights/tensor.h>

namespace earpoint {
namespace {

SofaFile small_head() {
  SofaFile head;
  head.sample_rate_hz = 44100;
  head.taps = 3;
  head.positions_m = {{1.0, 0.0, 0.0}, {0.0, 1.4, 0.25}};
  head.delays_samples = {{0.0, 1.5}, {2.0, 0.0}};
  for (int i = 0; i < 12; ++i) head.responses.push_back(static_cast<float>(i) / 8.0F);
  return head;
}

SofaFile through_bytes(const SafetensorsFile& file) {
  return read_head_file(parse_safetensors(serialize_safetensors(file, "head"), "head"), "head");
}

TEST(HeadFile, KeepsTheHead) {
  const SofaFile head = small_head();
  const SofaFile again = through_bytes(to_head_file(head));
  EXPECT_EQ(again.sample_rate_hz, head.sample_rate_hz);
  EXPECT_EQ(again.taps, head.taps);
  EXPECT_EQ(again.responses, head.responses);
  EXPECT_EQ(again.delays_samples, head.delays_samples);
  ASSERT_EQ(again.positions_m.size(), 2U);
  EXPECT_NEAR(again.positions_m[1].y, 1.4, 1e-6);
  EXPECT_EQ(again.positions_m[1].z, 0.25);
}

TEST(HeadFile, RefusesWhatDoesNotFit) {
  const auto refuses = [](SafetensorsFile file, const std::string& word) {
    try {
      (void)read_head_file(file, "head");
      ADD_FAILURE() << word;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  SafetensorsFile file = to_head_file(small_head());
  EXPECT_TRUE(is_head_file(file));
  file.tensors.erase("delays_samples");
  refuses(file, "delays_samples");
  file = to_head_file(small_head());
  const std::vector<float> one(6, 0.0F);
  file.tensors["responses"] = make_tensor(std::span<const float>(one), {1, 2, 3});
  refuses(file, "responses");
  file = to_head_file(small_head());
  file.metadata["sample_rate_hz"] = "12";
  refuses(std::move(file), "sample_rate_hz");
  EXPECT_FALSE(is_head_file(SafetensorsFile{}));
}

}  // namespace
}  // namespace earpoint
