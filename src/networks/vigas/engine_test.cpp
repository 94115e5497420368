#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core_testing/allocation_count.h>
#include <earpoint/network_testing/oracle_weights.h>
#include <earpoint/vigas/engine.h>
#include <earpoint/weights/checkpoint.h>

namespace earpoint {
namespace {

ViGas mini(int threads) {
  const std::string folder = EARPOINT_SOURCE_DIR "/src/networks/vigas/testdata/C_mini_noresnet/";
  return {make_oracle_vigas(folder + "manifest.json"), threads};
}

struct MiniInputs {
  std::vector<float> feature = std::vector<float>(512, 0.25F);
  std::vector<float> pose = {1.0F, 0.5F, -0.5F};
  std::vector<float> rotation = {0.0F, 1.0F};
  std::vector<float> boxes = {0.1F, 0.9F, 0.4F, 0.6F};

  [[nodiscard]] std::vector<ConditioningValues> values() const {
    return {{"visual_feat", feature},
            {"tgt_pose", pose},
            {"tgt_rotation", rotation},
            {"bboxes", boxes}};
  }
};

TEST(AllocationCount, CountsEveryKind) {
  // Through volatile pointers, as the compiler may leave out unused allocations.
  AllocationCount counted;
  int* volatile by_new = new int(1);
  void* volatile by_malloc = std::malloc(10);
  void* volatile by_aligned_alloc = std::aligned_alloc(64, 64);
  EXPECT_EQ(counted.count(), 3);
  delete by_new;
  std::free(by_malloc);
  std::free(by_aligned_alloc);
}

TEST(ViGas, AllocatesNothingAfterLoading) {
  ViGas network = mini(2);
  const MiniInputs inputs;
  const std::vector<ConditioningValues> values = inputs.values();
  const std::ptrdiff_t samples = network.description().window_samples;
  const std::vector<float> source(2 * samples, 0.5F);
  std::vector<float> output(source.size());
  std::vector<float> fused(network.description().conditioning_width);

  AllocationCount counted;
  network.fuse(values, fused);
  network.synthesize(source, fused, output);
  EXPECT_EQ(counted.count(), 0);
}

TEST(ViGas, AllocatesOnlyWhenTheLengthChanges) {
  ViGas network = mini(2);
  std::vector<float> fused(network.description().conditioning_width, 0.1F);
  const std::vector<float> source(6000, 0.5F);
  std::vector<float> output(source.size());
  network.synthesize(source, fused, output);

  AllocationCount counted;
  network.synthesize(source, fused, output);
  network.synthesize(source, fused, output);
  EXPECT_EQ(counted.count(), 0);
}

TEST(ViGas, InputsMayComeInAnyOrder) {
  ViGas network = mini(1);
  const MiniInputs inputs;
  std::vector<ConditioningValues> values = inputs.values();
  std::vector<float> fused(network.description().conditioning_width);
  std::vector<float> reversed(fused.size());
  network.fuse(values, fused);
  std::swap(values[0], values[3]);
  std::swap(values[1], values[2]);
  network.fuse(values, reversed);
  EXPECT_EQ(fused, reversed);
}

TEST(ViGas, MissingRepeatedAndWrongInputsAreRefused) {
  ViGas network = mini(1);
  const MiniInputs inputs;
  std::vector<float> fused(network.description().conditioning_width);

  std::vector<ConditioningValues> values = inputs.values();
  values.pop_back();
  EXPECT_THROW(network.fuse(values, fused), std::logic_error);
  values.push_back({"tgt_pose", inputs.pose});
  EXPECT_THROW(network.fuse(values, fused), std::logic_error);
  values.back() = {"bboxes", inputs.pose};
  EXPECT_THROW(network.fuse(values, fused), std::logic_error);
  EXPECT_THROW(static_cast<void>(network.image_feature(Image(8, 8, 3))), std::logic_error);
}

}  // namespace
}  // namespace earpoint
