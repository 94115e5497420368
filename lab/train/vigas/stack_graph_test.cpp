#include "graph.h"
#include "torch_tensor.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <ATen/Parallel.h>
#include <ATen/TensorOperators.h>
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <earpoint/core/random.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/train/initial_weights.h>

namespace earpoint {
namespace {

const at::Device kProcessor(at::kCPU);

struct Case {
  int channels = 8;
  int layers = 4;
  int kernel_size = 3;
  bool acausal = true;
  std::int64_t clips = 2;
  std::int64_t samples = 250;  ///< not a whole number of tiles
  int threads = 2;
};

ViGasDescription network_of(const Case& c) {
  ViGasDescription d;
  d.pose_encoding = PoseEncoding::full;
  d.box_encoding = BoxEncoding::corners;
  d.inputs = {{"tgt_pose", 3}, {"tgt_rotation", 6}};
  d.fusion_width = 16;
  d.conditioning_width = 8;
  d.channels = c.channels;
  d.blocks = 1;
  d.layers_per_block = c.layers;
  d.kernel_size = c.kernel_size;
  d.acausal = c.acausal;
  return d;
}

at::Tensor noise(const std::vector<std::int64_t>& shape, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()));
  for (float& value : values) value = static_cast<float>(0.5 * random.normal());
  return to_torch(values, shape, kProcessor);
}

struct Outcome {
  at::Tensor sound;
  std::map<std::string, at::Tensor> gradients;
};

/// A prediction, and the gradients of its product with noise.
Outcome run(const Case& c, StackKind kind) {
  at::set_num_threads(c.threads);
  ViGasWeights weights = initial_vigas_weights(network_of(c), 3);
  std::uint64_t seed = 100;
  for (auto& [name, tensor] : weights.tensors) {
    // Scaled so that sounds stay near 1 and gates are not saturated.
    const double inputs = static_cast<double>(tensor.elements() / tensor.shape[0]);
    tensor = from_torch(noise(tensor.shape, seed++) * (1.0 / std::sqrt(inputs)));
  }
  ViGasGraph graph(weights, kProcessor);
  const GraphInputs inputs{
      noise({c.clips, 2, c.samples}, 1),
      {},
      {{"tgt_pose", noise({c.clips, 3}, 2)}, {"tgt_rotation", noise({c.clips, 6}, 3)}}};
  Outcome outcome;
  outcome.sound = graph.forward(inputs, GraphMode::training, kind);
  (outcome.sound * noise({c.clips, 2, c.samples}, 4)).sum().backward();
  for (const auto& [name, parameter] : graph.parameters()) {
    outcome.gradients[name] = parameter.grad();
  }
  outcome.sound = outcome.sound.detach();
  return outcome;
}

void expect_near(const at::Tensor& found, const at::Tensor& expected, double tolerance,
                 const std::string& what) {
  const double scale = expected.abs().max().item<double>();
  EXPECT_LE((found - expected).abs().max().item<double>(), tolerance * scale) << what;
}

void expect_operations_result(const Case& c) {
  SCOPED_TRACE("channels " + std::to_string(c.channels) + ", threads " + std::to_string(c.threads));
  const Outcome expected = run(c, StackKind::operations);
  const Outcome found = run(c, StackKind::fused);
  // Two float32 implementations that sum hundreds of terms in different orders.
  expect_near(found.sound, expected.sound, 1e-5, "sound");
  ASSERT_EQ(found.gradients.size(), expected.gradients.size());
  for (const auto& [name, gradient] : expected.gradients) {
    ASSERT_TRUE(found.gradients.at(name).defined()) << name;
    expect_near(found.gradients.at(name), gradient, 2e-5, name);
  }
}

TEST(FusedStack, IsLibTorchsOperationsForAnyWidth) {
  for (const int channels : {1, 8, 16, 20, 32, 48, 64, 80}) {
    expect_operations_result({.channels = channels});
  }
}

TEST(FusedStack, IsLibTorchsOperationsForAnyConvolution) {
  expect_operations_result({.layers = 1});
  expect_operations_result({.layers = 7});  // side taps see nothing but zeros
  expect_operations_result({.kernel_size = 2, .acausal = false});
  expect_operations_result({.kernel_size = 5});
  expect_operations_result({.kernel_size = 1});
  expect_operations_result({.samples = 5});
}

TEST(FusedStack, IsLibTorchsOperationsHoweverClipsAreShared) {
  for (const int threads : {1, 2, 3}) {
    for (const std::int64_t clips : {1, 2, 3, 4}) {
      expect_operations_result({.clips = clips, .threads = threads});
    }
  }
}

TEST(FusedStack, IsLibTorchsOperationsOnEveryInstructionSet) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    for (const int channels : {16, 32, 48, 64}) expect_operations_result({.channels = channels});
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(FusedStack, GivesTheSameNumbersAgain) {
  for (const std::int64_t clips : {2, 3}) {
    const Outcome first = run({.clips = clips}, StackKind::fused);
    const Outcome second = run({.clips = clips}, StackKind::fused);
    for (const auto& [name, gradient] : first.gradients) {
      EXPECT_TRUE(from_torch(gradient) == from_torch(second.gradients.at(name))) << name;
    }
  }
}

TEST(FusedStack, RefusesTheGradientOfAnEarlierResult) {
  const Case c;
  ViGasGraph graph(initial_vigas_weights(network_of(c), 3), kProcessor);
  const GraphInputs inputs{
      noise({c.clips, 2, c.samples}, 1),
      {},
      {{"tgt_pose", noise({c.clips, 3}, 2)}, {"tgt_rotation", noise({c.clips, 6}, 3)}}};
  const at::Tensor earlier = graph.forward(inputs, GraphMode::training).sum();
  const at::Tensor later = graph.forward(inputs, GraphMode::training).sum();
  EXPECT_THROW(earlier.backward(), std::logic_error);
  EXPECT_NO_THROW(later.backward());
}

}  // namespace
}  // namespace earpoint
