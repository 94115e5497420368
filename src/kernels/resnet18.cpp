#include <earpoint/kernels/resnet18.h>

#include <fmt/format.h>

#include <earpoint/kernels/convolution_chain.h>
#include <earpoint/kernels/openmp_threads.h>

namespace earpoint::kernels {

struct ResNet18::State {
  ConvolutionChain chain;
};

ResNet18::ResNet18(const TensorByName& tensor, const std::string& prefix, int channels, int height,
                   int width, int threads)
    : state_(std::make_unique<State>(State{{channels, height, width, threads}})) {
  const OpenMpThreads team(threads);
  ConvolutionChain& chain = state_->chain;
  dnnl::memory x = chain.add_convolution(
      chain.picture(), fold_batch_norm(tensor, prefix + ".0", prefix + ".1", false),
      {.size = 7, .stride = 2}, After::relu);
  x = chain.add_max_pool(x);
  for (int stage = 4; stage <= 7; ++stage) {
    for (int block = 0; block < 2; ++block) {
      x = chain.add_block(x, tensor, fmt::format("{}.{}.{}.", prefix, stage, block),
                          stage > 4 && block == 0);
    }
  }
  chain.finish(x);
}

ResNet18::~ResNet18() = default;
ResNet18::ResNet18(ResNet18&&) noexcept = default;
ResNet18& ResNet18::operator=(ResNet18&&) noexcept = default;

int ResNet18::map_height() const { return state_->chain.map_height(); }
int ResNet18::map_width() const { return state_->chain.map_width(); }
int ResNet18::channels() const { return state_->chain.map_channels(); }

void ResNet18::run(std::span<const float> picture, std::span<float> map) {
  state_->chain.run(picture, map);
}

}  // namespace earpoint::kernels
