#include <earpoint/vam/engine.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/kernels/dense.h>
#include <earpoint/kernels/matrix.h>
#include <earpoint/kernels/openmp_threads.h>
#include <earpoint/kernels/resnet18.h>
#include <earpoint/kernels/strided.h>
#include <earpoint/network/picture_planes.h>
#include <earpoint/vam/encoding.h>

namespace earpoint {
namespace {

using Floats = std::vector<float>;

/// [rows][columns] as [columns][rows].
Floats transposed(std::span<const float> values, int rows) {
  const std::size_t columns = values.size() / static_cast<std::size_t>(rows);
  Floats result(values.size());
  for (std::size_t r = 0; r < static_cast<std::size_t>(rows); ++r) {
    for (std::size_t c = 0; c < columns; ++c) result[c * rows + r] = values[r * columns + c];
  }
  return result;
}

/// Every row with the numbers of `pose` appended.
Floats with_pose(std::span<const float> rows, int width, std::span<const float> pose) {
  Floats result;
  result.reserve(rows.size() + rows.size() / static_cast<std::size_t>(width) * pose.size());
  for (std::size_t at = 0; at < rows.size(); at += static_cast<std::size_t>(width)) {
    const auto row = rows.subspan(at, static_cast<std::size_t>(width));
    result.insert(result.end(), row.begin(), row.end());
    result.insert(result.end(), pose.begin(), pose.end());
  }
  return result;
}

void add(Floats& to, std::span<const float> what) {
  EARPOINT_CHECK(to.size() == what.size());
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += what[i];
}

/// Columns `first` to `first + count` of every row.
Floats columns_of(std::span<const float> rows, int width, int first, int count) {
  Floats part;
  for (std::size_t at = 0; at < rows.size(); at += static_cast<std::size_t>(width)) {
    const auto row =
        rows.subspan(at + static_cast<std::size_t>(first), static_cast<std::size_t>(count));
    part.insert(part.end(), row.begin(), row.end());
  }
  return part;
}

}  // namespace

struct Vam::State {
  State(VamWeights given, int thread_count)
      : weights(std::move(given)),
        threads(thread_count),
        trunk([this](const std::string& name) -> const Tensor& { return weights.at(name); },
              "visual_encoder", 3, weights.description.image_height_px,
              weights.description.image_width_px, threads) {}

  [[nodiscard]] std::span<const float> values(const std::string& name) const {
    return weights.at(name).as<float>();
  }

  [[nodiscard]] Floats layer(const std::string& name, std::span<const float> rows) const {
    const auto weight = values(name + ".weight");
    const auto bias = values(name + ".bias");
    const int count = static_cast<int>(rows.size() * bias.size() / weight.size());
    Floats out(bias.size() * static_cast<std::size_t>(count));
    kernels::linear(rows, weight, bias, out, count);
    return out;
  }

  [[nodiscard]] Floats normed(const std::string& name, std::span<const float> rows) const {
    Floats out(rows.size());
    kernels::layer_norm(rows, values(name + ".weight"), values(name + ".bias"), out);
    return out;
  }

  [[nodiscard]] kernels::StridedShape shape_of(int level) const {
    return {weights.description.strides[level], weights.description.padding(level)};
  }

  [[nodiscard]] Floats image_tokens(std::span<const float> map, std::span<const float> pose) const;
  [[nodiscard]] Floats attend(const std::string& name, std::span<const float> asking,
                              std::span<const float> asked) const;
  [[nodiscard]] Floats convolve_tokens(const std::string& name, std::span<const float> rows) const;
  void run_block(const std::string& name, Floats& tokens, std::span<const float> image) const;
  [[nodiscard]] Floats fuse(std::span<const float> deepest, std::span<const float> map,
                            std::span<const float> pose) const;

  VamWeights weights;
  int threads;
  kernels::ResNet18 trunk;
};

Floats Vam::State::image_tokens(std::span<const float> map, std::span<const float> pose) const {
  const int width = weights.description.map_channels();
  Floats tokens = layer("image_projection", with_pose(transposed(map, width), width, pose));
  add(tokens, values("image_position"));
  return tokens;
}

/// Multi-head attention, without the residual connection.
Floats Vam::State::attend(const std::string& name, std::span<const float> asking,
                          std::span<const float> asked) const {
  const int width = weights.description.width();
  const int part = width / weights.description.heads;
  const Floats queries = layer(name + ".query", asking);
  const Floats keys = layer(name + ".key", asked);
  const Floats contents = layer(name + ".value", asked);
  const int rows = static_cast<int>(queries.size()) / width;
  const int columns = static_cast<int>(keys.size()) / width;
  Floats joined(queries.size());
  Floats scores(static_cast<std::size_t>(rows) * columns);
  Floats heard(static_cast<std::size_t>(rows) * part);
  for (int first = 0; first < width; first += part) {
    kernels::multiply_transposed(columns_of(queries, width, first, part),
                                 columns_of(keys, width, first, part), scores, rows, part, columns);
    for (float& score : scores) score /= std::sqrt(static_cast<float>(part));
    kernels::softmax_rows(scores, columns);
    kernels::multiply(scores, columns_of(contents, width, first, part), heard, rows, columns, part);
    for (std::ptrdiff_t row = 0; row < rows; ++row) {
      std::copy_n(heard.begin() + row * part, part, joined.begin() + row * width + first);
    }
  }
  return layer(name + ".output", joined);
}

/// The convolution of a conformer: gated, then over neighbours channel by channel.
Floats Vam::State::convolve_tokens(const std::string& name, std::span<const float> rows) const {
  const int width = weights.description.width();
  const int taps = weights.description.kernel_size;
  const Floats expanded = layer(name + ".expand", normed(name + ".norm", rows));
  const int length = static_cast<int>(rows.size()) / width;
  Floats gated(rows.size());
  for (std::ptrdiff_t t = 0; t < length; ++t) {
    const float* row = expanded.data() + t * 2 * width;
    for (int c = 0; c < width; ++c)
      gated[t * width + c] = row[c] / (1.0F + std::exp(-row[width + c]));
  }
  const auto weight = values(name + ".depthwise.weight");
  const auto bias = values(name + ".depthwise.bias");
  Floats out(rows.size());
  for (std::ptrdiff_t t = 0; t < length; ++t) {
    std::copy(bias.begin(), bias.end(), out.begin() + t * width);
    for (int tap = 0; tap < taps; ++tap) {
      const std::ptrdiff_t from = t + tap - taps / 2;
      if (from < 0 || from >= length) continue;
      for (int c = 0; c < width; ++c) {
        out[t * width + c] += weight[c * taps + tap] * gated[from * width + c];
      }
    }
  }
  kernels::silu(out);
  return layer(name + ".project", out);
}

void Vam::State::run_block(const std::string& name, Floats& tokens,
                           std::span<const float> image) const {
  const Floats alone = normed(name + ".self.norm", tokens);
  add(tokens, attend(name + ".self", alone, alone));
  add(tokens, attend(name + ".cross", normed(name + ".cross.norm", tokens), image));
  add(tokens, convolve_tokens(name + ".convolution", tokens));
  Floats hidden = layer(name + ".feed_forward.expand", normed(name + ".feed_forward.norm", tokens));
  kernels::silu(hidden);
  add(tokens, layer(name + ".feed_forward.project", hidden));
}

/// @param deepest  the encoder's output for the sound, [width][tokens]
/// @return         the same, fused with the picture
Floats Vam::State::fuse(std::span<const float> deepest, std::span<const float> map,
                        std::span<const float> pose) const {
  const int width = weights.description.width();
  const Floats image = image_tokens(map, pose);
  Floats tokens = layer("sound_projection", with_pose(transposed(deepest, width), width, pose));
  for (int block = 0; block < weights.description.blocks; ++block) {
    run_block(fmt::format("blocks.{}", block), tokens, image);
  }
  const int count = static_cast<int>(tokens.size()) / width;
  return transposed(normed("norm", tokens), count);
}

Vam::Vam(VamWeights weights, int threads)
    : state_(std::make_unique<State>(std::move(weights), threads)) {}
Vam::~Vam() = default;
Vam::Vam(Vam&&) noexcept = default;
Vam& Vam::operator=(Vam&&) noexcept = default;

const VamDescription& Vam::description() const { return state_->weights.description; }

std::vector<float> Vam::image_map(const Image& picture) {
  return image_map(
      picture_planes(picture, description().image_width_px, description().image_height_px));
}

std::vector<float> Vam::image_map(std::span<const float> picture) {
  Floats map(static_cast<std::size_t>(description().map_channels()) * description().image_tokens());
  state_->trunk.run(picture, map);
  return map;
}

void Vam::synthesize(std::span<const float> source, std::span<const float> map,
                     std::span<const float> pose, std::span<float> output) {
  const State& state = *state_;
  const VamDescription& d = description();
  EARPOINT_CHECK(pose.size() == VamDescription::kPoseWidth && output.size() == source.size());
  const kernels::OpenMpThreads team(state.threads);
  const std::ptrdiff_t samples = std::ssize(source) / d.audio_channels;
  const std::ptrdiff_t whole =
      (samples + d.token_samples() - 1) / d.token_samples() * d.token_samples();
  Floats sound(static_cast<std::size_t>(whole * d.audio_channels));
  for (int c = 0; c < d.audio_channels; ++c) {
    std::copy_n(source.begin() + c * samples, samples, sound.begin() + c * whole);
  }

  std::vector<Floats> levels;
  for (int level = 0; level < d.levels(); ++level) {
    const std::string name = fmt::format("encoder.{}", level);
    levels.push_back(kernels::convolve_strided(
        level == 0 ? sound : levels.back(), d.encoder_inputs(level), state.values(name + ".weight"),
        state.values(name + ".bias"), state.shape_of(level)));
    kernels::silu(levels.back());
  }
  Floats x = state.fuse(levels.back(), map, pose);
  for (int level = d.levels() - 1; level >= 0; --level) {
    const std::string name = fmt::format("decoder.{}", level);
    x.insert(x.end(), levels[level].begin(), levels[level].end());
    x = kernels::convolve_transposed(x, 2 * d.channels[level], state.values(name + ".weight"),
                                     state.values(name + ".bias"), state.shape_of(level));
    kernels::silu(x);
  }
  x.insert(x.end(), sound.begin(), sound.end());
  const auto weight = state.values("output.weight");
  const int inputs = d.decoder_outputs(0) + d.audio_channels;
  const int taps = static_cast<int>(weight.size()) / (inputs * d.audio_channels);
  const Floats result =
      kernels::convolve_strided(x, inputs, weight, state.values("output.bias"), {1, taps / 2});
  for (int c = 0; c < d.audio_channels; ++c) {
    std::copy_n(result.begin() + c * whole, samples, output.begin() + c * samples);
  }
}

}  // namespace earpoint
