#include <earpoint/kernels/stack_plan.h>

#include <algorithm>

#include <earpoint/error.h>

namespace earpoint::kernels {
namespace {

/// Single taps for `width` outputs from `phase` on; taps that see only padding are left out.
Sweep sweep_of_taps(const DilatedConvolution& convolution, std::ptrdiff_t samples,
                    std::ptrdiff_t phase, std::ptrdiff_t width) {
  Sweep sweep{.scheme = Scheme::taps, .step = convolution.dilation};
  const std::ptrdiff_t centre = convolution.centre();
  const std::ptrdiff_t reach = (samples - 1) / convolution.dilation;
  sweep.first_tap = centre - std::min(reach, centre);
  const std::ptrdiff_t last_tap = centre + std::min(reach, convolution.taps - 1 - centre);
  sweep.taps = last_tap - sweep.first_tap + 1;
  sweep.first_offset = (sweep.first_tap - centre) * convolution.dilation;
  sweep.phase = phase;
  sweep.width = width;
  sweep.columns = width;
  return sweep;
}

/// One group of a lattice scheme for every phase in a range.
Sweep sweep_of_lattice(Scheme scheme, std::ptrdiff_t step, std::ptrdiff_t phase,
                       std::ptrdiff_t width) {
  return {.scheme = scheme,
          .first_offset = shape_of(scheme).first_input * step,
          .step = step,
          .phase = phase,
          .width = width,
          .columns = width};
}

/// Dilations below this have runs shorter than a vector, and change to segmented order.
constexpr std::ptrdiff_t kSmallDilation = kSegments;
/// Shorter segments than one group of four outputs would waste columns.
constexpr std::ptrdiff_t kSegmentDilations = 4;

}  // namespace

std::ptrdiff_t LayerPlan::tiles() const {
  std::ptrdiff_t tiles = 0;
  for (const Sweep& sweep : used()) tiles += sweep.tiles();
  return tiles;
}

LayerPlan plan_layer(const DilatedConvolution& convolution, std::ptrdiff_t samples) {
  EARPOINT_CHECK(samples > 0);
  const std::ptrdiff_t d = convolution.dilation;
  LayerPlan plan;
  plan.order.samples = samples;
  const auto add = [&plan](const Sweep& sweep) { plan.sweeps[plan.sweep_count++] = sweep; };

  const std::ptrdiff_t points = (samples + d - 1) / d;  // of the longest lattice
  if (convolution.taps != 3 || !convolution.acausal || points == 1) {
    add(sweep_of_taps(convolution, samples, 0, samples));
    return plan;
  }
  if (points <= 3) {
    // The first phases have one point more than the others.
    const std::ptrdiff_t longer = samples - (points - 1) * d;
    if (points == 3) {
      add(sweep_of_lattice(Scheme::three, d, 0, longer));
      if (longer < d) add(sweep_of_lattice(Scheme::two, d, longer, d - longer));
    } else {
      add(sweep_of_lattice(Scheme::two, d, 0, longer));
      DilatedConvolution alone = convolution;
      alone.dilation = samples;
      if (longer < d) add(sweep_of_taps(alone, samples, longer, d - longer));
    }
    return plan;
  }

  std::ptrdiff_t step = d;
  const std::ptrdiff_t segment = (samples + kSegments - 1) / kSegments;
  if (d < kSmallDilation && segment >= kSegmentDilations * d) {
    plan.order.segment = segment;
    step = d * kSegments;
  }
  Sweep sweep = sweep_of_lattice(Scheme::four, step, 0, step);
  // Columns past the last place have no output in the plane; they end the last group.
  const std::ptrdiff_t group_places = shape_of(Scheme::four).outputs * step;
  const std::ptrdiff_t groups = plan.order.places() / group_places;
  const std::ptrdiff_t rest = plan.order.places() - groups * group_places;
  sweep.columns = groups * step + std::min(rest, step);
  add(sweep);
  return plan;
}

}  // namespace earpoint::kernels
