#include <earpoint/network/layer_shapes.h>

#include <utility>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {

void check_range(std::string_view where, std::string_view field, std::int64_t value,
                 std::int64_t least, std::int64_t most) {
  if (value >= least && value <= most) return;
  const std::string expected =
      least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most);
  throw InputError(where, fmt::format("{}: expected {}, found {}", field, expected, value));
}

void add_batch_norm(TensorShapes& shapes, const std::string& prefix, std::int64_t channels) {
  for (const char* name : {"weight", "bias", "running_mean", "running_var"}) {
    shapes[fmt::format("{}.{}", prefix, name)] = {channels};
  }
}

void add_residual_block(TensorShapes& shapes, const std::string& name, std::int64_t from,
                        std::int64_t to) {
  shapes[name + ".conv1.weight"] = {to, from, 3, 3};
  add_batch_norm(shapes, name + ".bn1", to);
  shapes[name + ".conv2.weight"] = {to, to, 3, 3};
  add_batch_norm(shapes, name + ".bn2", to);
  if (from == to) return;
  shapes[name + ".downsample.0.weight"] = {to, from, 1, 1};
  add_batch_norm(shapes, name + ".downsample.1", to);
}

void add_resnet18(TensorShapes& shapes, const std::string& prefix, std::int64_t image_channels,
                  std::int64_t channels) {
  shapes[prefix + ".0.weight"] = {channels, image_channels, 7, 7};
  add_batch_norm(shapes, prefix + ".1", channels);
  std::int64_t from = channels;
  for (int stage = 0; stage < 4; ++stage) {
    const std::int64_t to = channels << stage;
    for (int block = 0; block < 2; ++block) {
      const std::string name = fmt::format("{}.{}.{}", prefix, stage + 4, block);
      add_residual_block(shapes, name, from, to);
      from = to;
    }
  }
}

void add_layer(TensorShapes& shapes, const std::string& name, std::vector<std::int64_t> weight) {
  shapes[name + ".bias"] = {weight[0]};
  shapes[name + ".weight"] = std::move(weight);
}

}  // namespace earpoint
