#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <oneapi/dnnl/dnnl.hpp>

#include <earpoint/kernels/folded_convolution.h>

namespace earpoint::kernels {

/// What a convolution does to its sums.
enum class After { nothing, relu };

/// A fixed sequence of oneDNN's operations on one picture, laid out once and run many times. Maps
/// lie in whatever order oneDNN likes best; `map` and `picture` in [channels][height][width].
class ConvolutionChain {
 public:
  /// Kernel, stride and padding of a square window.
  struct Window {
    int size = 3;
    int stride = 1;
    [[nodiscard]] int padding() const { return size / 2; }
  };

  /// @param threads  that run() takes
  ConvolutionChain(int channels, int height, int width, int threads);

  /// The picture, where the chain begins.
  [[nodiscard]] const dnnl::memory& picture() const { return picture_; }

  /// Adds convolution + bias, then optionally + what `add_to` holds (and replaces it), then
  /// `after`.
  dnnl::memory add_convolution(const dnnl::memory& from, const FoldedConvolution& folded,
                               Window window, After after, const dnnl::memory* add_to = nullptr);

  /// 3x3, stride 2, padding 1; padding never wins.
  dnnl::memory add_max_pool(const dnnl::memory& from);

  /// Residual block: two 3x3 convolutions beside an identity, or a 1x1 convolution where it halves.
  dnnl::memory add_block(const dnnl::memory& from, const TensorByName& tensor,
                         const std::string& name, bool halve);

  /// Adds `from`, every value four times, to a map of twice its height and width, in place.
  void add_upsampled(const dnnl::memory& from, const dnnl::memory& to);

  /// Ends the chain: run() gives this map.
  void finish(const dnnl::memory& last);

  [[nodiscard]] int map_channels() const { return map_size(1); }
  [[nodiscard]] int map_height() const { return map_size(2); }
  [[nodiscard]] int map_width() const { return map_size(3); }

  /// Allocates nothing.
  /// @param picture  [channels][height][width]
  /// @param map      [map_channels()][map_height()][map_width()]
  void run(std::span<const float> picture, std::span<float> map);

 private:
  [[nodiscard]] dnnl::memory make(const dnnl::memory::desc& desc) const { return {desc, engine_}; }
  [[nodiscard]] int map_size(std::size_t axis) const {
    return static_cast<int>(map_.get_desc().dims()[axis]);
  }
  /// A copy in another layout, made now.
  dnnl::memory reordered(dnnl::memory from, const dnnl::memory::desc& to);
  void add_step(dnnl::primitive primitive, std::unordered_map<int, dnnl::memory> arguments);

  int threads_;
  dnnl::engine engine_{dnnl::engine::kind::cpu, 0};
  dnnl::stream stream_{engine_};
  std::vector<std::pair<dnnl::primitive, std::unordered_map<int, dnnl::memory>>> steps_;
  dnnl::memory picture_;
  dnnl::memory map_;
};

}  // namespace earpoint::kernels
