#include "stack_parameters.h"

#include "stack_kernels.h"

#include <iterator>
#include <tuple>

namespace earpoint::training {

StackSizes stack_sizes(const StackShape& shape, std::ptrdiff_t clips) {
  const std::ptrdiff_t c = shape.channels;
  const std::ptrdiff_t layers = shape.layers();
  return {kChannelStep * c,
          c,
          layers * shape.taps * c * 2 * c,
          (layers - 1) * c * c,
          (layers - 1) * c,
          layers * c * c,
          c,
          c * c,
          c,
          c * kChannelStep,
          kChannelStep,
          clips * layers * 2 * c};
}

StackParameters<float> consecutive(const StackSizes& sizes, float* all) {
  StackParameters<float> found;
  float** const places[] = {&found.input,     &found.input_bias,    &found.gate,
                            &found.residual,  &found.residual_bias, &found.skip,
                            &found.skip_bias, &found.first,         &found.first_bias,
                            &found.second,    &found.second_bias,   &found.constants};
  static_assert(std::size(places) == std::tuple_size_v<StackSizes>);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    *places[i] = all;
    all += sizes[i];
  }
  return found;
}

}  // namespace earpoint::training
