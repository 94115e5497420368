#include <earpoint/render/dsp_stream.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/audio/peak_limiter.h>
#include <earpoint/core/ears.h>
#include <earpoint/error.h>
#include <earpoint/spatial/dsp_renderer.h>
#include <earpoint/spatial/speaker_direction.h>
#include <earpoint/synthesis/earpoint_path.h>

namespace earpoint {
namespace {

using Spectrum = std::vector<std::complex<float>>;

constexpr double kBlock_s = 0.01;
constexpr int kFadeBlocks = 4;  // from one earpoint's filters to the next

/// target += a * b; written out because std::complex's product checks for NaN.
void add_product(std::span<const std::complex<float>> a, std::span<const std::complex<float>> b,
                 std::span<std::complex<float>> target) {
  for (std::size_t k = 0; k < target.size(); ++k) {
    const float real = a[k].real() * b[k].real() - a[k].imag() * b[k].imag();
    const float imaginary = a[k].real() * b[k].imag() + a[k].imag() * b[k].real();
    target[k] = {target[k].real() + real, target[k].imag() + imaginary};
  }
}

/// What the filters depend on.
struct Place {
  std::optional<Vector3> mouth_m;
  Pose source_from_target;
  friend bool operator==(const Place&, const Place&) = default;
};

/// The unchanged sound, as late as the filters make it. Allocates nothing if the matrix has that
/// length.
void pass_through(std::size_t taps, int delay_samples, EarFilterMatrix& matrix) {
  matrix.delay_samples = delay_samples;
  for (std::size_t target = 0; target < kEars; ++target) {
    for (std::size_t source = 0; source < kEars; ++source) {
      matrix.taps[target][source].assign(taps, 0.0F);
    }
    matrix.taps[target][target][static_cast<std::size_t>(delay_samples)] = 1.0F;
  }
}

/// Two ears in, two ears out, block by block, through filters that may change from block to block:
/// partitioned convolution as by PartitionedConvolver, with the history of the ears apart from the
/// filters.
class EarFilters {
 public:
  /// The spectra of a matrix's partitions.
  using Partitions = std::array<std::array<std::vector<Spectrum>, kEars>, kEars>;

  EarFilters(int block, std::size_t taps)
      : block_(static_cast<std::size_t>(block)),
        count_((taps + block_ - 1) / block_),
        fft_(2 * block),
        sum_(fft_.bins()),
        circular_(2 * block_) {
    for (std::size_t ear = 0; ear < kEars; ++ear) {
      windows_[ear].resize(2 * block_);
      history_[ear].assign(count_, Spectrum(fft_.bins()));
    }
  }

  /// Room for the partitions of a matrix.
  [[nodiscard]] Partitions empty_partitions() const {
    Partitions result;
    for (auto& of_target : result) {
      for (std::vector<Spectrum>& filter : of_target) filter.assign(count_, Spectrum(fft_.bins()));
    }
    return result;
  }

  void split(const EarFilterMatrix& matrix, Partitions& result) {
    for (std::size_t target = 0; target < kEars; ++target) {
      for (std::size_t source = 0; source < kEars; ++source) {
        const std::span<const float> taps = matrix.taps[target][source];
        for (std::size_t p = 0; p < count_; ++p) {
          const std::size_t start = p * block_;
          std::ranges::fill(circular_, 0.0F);
          std::ranges::copy(taps.subspan(start, std::min(block_, taps.size() - start)),
                            circular_.begin());
          fft_.forward(circular_, result[target][source][p]);
        }
      }
    }
  }

  /// @param in  one block of each ear, planar
  void push(std::span<const float> in) {
    newest_ = (newest_ + count_ - 1) % count_;
    for (std::size_t ear = 0; ear < kEars; ++ear) {
      std::vector<float>& window = windows_[ear];
      std::copy_n(window.begin() + std::ssize(in) / 2, block_, window.begin());
      std::ranges::copy(in.subspan(ear * block_, block_), window.begin() + std::ssize(in) / 2);
      fft_.forward(window, history_[ear][newest_]);
    }
  }

  /// What the filters make of the block that was pushed last: one block of each ear, planar.
  void filter(const Partitions& filters, std::span<float> out) {
    for (std::size_t target = 0; target < kEars; ++target) {
      std::ranges::fill(sum_, std::complex<float>{});
      for (std::size_t source = 0; source < kEars; ++source) {
        for (std::size_t p = 0; p < count_; ++p) {
          add_product(history_[source][(newest_ + p) % count_], filters[target][source][p], sum_);
        }
      }
      fft_.inverse(sum_, circular_);
      std::copy_n(circular_.begin() + static_cast<std::ptrdiff_t>(block_), block_,
                  out.begin() + static_cast<std::ptrdiff_t>(target * block_));
    }
  }

  void reset() {
    for (std::size_t ear = 0; ear < kEars; ++ear) {
      std::ranges::fill(windows_[ear], 0.0F);
      for (Spectrum& spectrum : history_[ear]) std::ranges::fill(spectrum, std::complex<float>{});
    }
  }

 private:
  std::size_t block_;
  std::size_t count_;  ///< of a filter's partitions
  RealFft<float> fft_;
  std::array<std::vector<float>, kEars> windows_;     ///< the last two blocks of each ear
  std::array<std::vector<Spectrum>, kEars> history_;  ///< of the windows, as rings
  std::size_t newest_ = 0;
  Spectrum sum_;
  std::vector<float> circular_;
};

}  // namespace

struct DspStream::State {
  State(const HrtfSet& head, const Options& options_in)
      : options(options_in),
        block(std::lround(kBlock_s * head.sample_rate_hz())),
        designer(head),
        filters(static_cast<int>(block), static_cast<std::size_t>(designer.taps())),
        now(filters.empty_partitions()),
        next(now),
        limiter(kEars, head.sample_rate_hz()) {
    design({}, now);
    for (std::vector<float>* buffer : {&in, &out, &faded}) {
      buffer->resize(kEars * static_cast<std::size_t>(block));
    }
  }

  /// Takes 1 to 3 ms, and allocates nothing once it was called.
  void design(const Place& place, EarFilters::Partitions& result) {
    if (place.mouth_m) {
      designer.design(*place.mouth_m, place.source_from_target, matrix);
    } else {
      pass_through(static_cast<std::size_t>(designer.taps()), designer.delay_samples(), matrix);
    }
    filters.split(matrix, result);
  }

  [[nodiscard]] Place wanted() const { return {mouth_m ? mouth_m : seen_m, source_from_target}; }

  void run_block();
  void fade();

  Options options;
  std::ptrdiff_t block;
  DspFilterDesigner designer;
  EarFilterMatrix matrix;  ///< the last design
  EarFilters filters;
  EarFilters::Partitions now;   ///< filters in use
  EarFilters::Partitions next;  ///< what they fade into
  Place of_next;                ///< where `next`, or `now` if nothing fades, is for
  int fading = 0;               ///< blocks that are left of the fade
  bool starts = true;           ///< nothing was heard yet, so nothing to fade from
  PeakLimiter limiter;

  Pose source_from_target;
  std::optional<Vector3> mouth_m;
  std::optional<Vector3> seen_m;

  // Of a block, planar.
  std::vector<float> in;
  std::vector<float> out;
  std::vector<float> faded;
  std::ptrdiff_t filled = 0;  ///< samples of `in`, and read ones of `out`
};

void DspStream::State::fade() {
  filters.filter(next, faded);
  const int done = kFadeBlocks - fading;
  for (std::size_t ear = 0; ear < kEars; ++ear) {
    for (std::ptrdiff_t i = 0; i < block; ++i) {
      const float share =
          static_cast<float>(done * block + i + 1) / static_cast<float>(kFadeBlocks * block);
      float& sample = out[ear * block + i];
      sample = std::lerp(sample, faded[ear * block + i], share);
    }
  }
  if (--fading == 0) std::swap(now, next);
}

void DspStream::State::run_block() {
  for (float& sample : in) sample = std::isfinite(sample) ? sample : 0.0F;
  if (fading == 0 && wanted() != of_next) {
    of_next = wanted();
    design(of_next, starts ? now : next);
    fading = starts ? 0 : kFadeBlocks;
  }
  starts = false;
  filters.push(in);
  filters.filter(now, out);
  if (fading > 0) fade();
  if (options.limit) limiter.process_late(out);
}

DspStream::DspStream(const HrtfSet& head, const Options& options)
    : state_(std::make_unique<State>(head, options)) {}
DspStream::~DspStream() = default;
DspStream::DspStream(DspStream&&) noexcept = default;
DspStream& DspStream::operator=(DspStream&&) noexcept = default;

void DspStream::see(const Image* picture, const std::optional<Box>& speaker_box) {
  if (!speaker_box) {
    state_->seen_m.reset();
    return;
  }
  if (picture == nullptr) {
    throw InputError("the speaker's box", "cannot be used without a picture",
                     "give the picture too, or the speaker's position");
  }
  state_->seen_m = cartesian_from_spherical(speaker_direction_from_box(
      *speaker_box, state_->options.horizontal_fov_rad, picture->width(), picture->height()));
}

void DspStream::place_speaker(const std::optional<Vector3>& mouth_m) {
  if (mouth_m) check_place(*mouth_m, "speaker");
  state_->mouth_m = mouth_m;
}

void DspStream::move_to(const Pose& source_from_target) {
  check_pose(source_from_target, "earpoint");
  state_->source_from_target = source_from_target;
}

void DspStream::process(std::array<std::span<const float>, 2> in,
                        std::array<std::span<float>, 2> out) {
  State& s = *state_;
  EARPOINT_CHECK(in[0].size() == in[1].size() && out[0].size() == in[0].size() &&
                 out[1].size() == in[0].size());
  const std::ptrdiff_t samples = std::ssize(in[0]);
  for (std::ptrdiff_t done = 0; done < samples;) {
    const std::ptrdiff_t count = std::min(samples - done, s.block - s.filled);
    const auto place = [&](std::size_t e) {
      return static_cast<std::ptrdiff_t>(e) * s.block + s.filled;
    };
    // Both are read before one is written: an ear of `out` may be the memory of either of `in`.
    for (std::size_t e = 0; e < kEars; ++e) {
      std::copy_n(in[e].begin() + done, count, s.in.begin() + place(e));
    }
    for (std::size_t e = 0; e < kEars; ++e) {
      std::copy_n(s.out.begin() + place(e), count, out[e].begin() + done);
    }
    done += count;
    s.filled += count;
    if (s.filled == s.block) {
      s.run_block();
      s.filled = 0;
    }
  }
}

std::ptrdiff_t DspStream::latency_samples() const {
  const State& s = *state_;
  return s.block + s.designer.delay_samples() + (s.options.limit ? s.limiter.latency_samples() : 0);
}

std::optional<Vector3> DspStream::speaker_m() const { return state_->wanted().mouth_m; }

void DspStream::reset() {
  State& s = *state_;
  s.filters.reset();
  s.limiter.reset();
  if (s.fading > 0) std::swap(s.now, s.next);
  s.fading = 0;
  s.starts = true;
  std::ranges::fill(s.out, 0.0F);
  s.filled = 0;
}

}  // namespace earpoint
