// Where the columns of a tile lie in a plane. Included once per instruction set.

#if defined(EARPOINT_KERNELS_COLUMNS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef EARPOINT_KERNELS_COLUMNS_INL_H_
#undef EARPOINT_KERNELS_COLUMNS_INL_H_
#else
#define EARPOINT_KERNELS_COLUMNS_INL_H_
#endif

#include "gemm-inl.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include <hwy/highway.h>

#include <earpoint/kernels/tile_kernels.h>

HWY_BEFORE_NAMESPACE();
namespace earpoint::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Columns side by side whose places are side by side, too.
struct Run {
  std::ptrdiff_t lane;    ///< of the first column, in its vector
  std::ptrdiff_t length;  ///< columns
  std::ptrdiff_t place;   ///< of the first column's first output
};

/// The columns of a tile, vector by vector. Columns past the end of the sweep are in no run.
struct TileRuns {
  std::ptrdiff_t begin[kTileVectors + 1];
  Run runs[2 * kTileColumns];

  [[nodiscard]] std::span<const Run> of_vector(std::ptrdiff_t v) const {
    return {runs + begin[v], runs + begin[v + 1]};
  }
  /// Whether a vector's columns are one run and, moved by first..last, within the plane.
  [[nodiscard]] bool is_whole(std::ptrdiff_t v, std::ptrdiff_t first, std::ptrdiff_t last,
                              std::ptrdiff_t places) const {
    const Run& run = runs[begin[v]];
    return begin[v + 1] == begin[v] + 1 && run.length == kLanes && run.place + first >= 0 &&
           run.place + last + kLanes <= places;
  }
};

inline HWY_ATTR TileRuns find_runs(const Sweep& sweep, std::ptrdiff_t tile) {
  TileRuns found{};
  std::ptrdiff_t count = 0;
  const std::ptrdiff_t group_places = shape_of(sweep.scheme).outputs * sweep.step;
  std::ptrdiff_t column = tile * kTileColumns;
  std::ptrdiff_t group = column / sweep.width;
  std::ptrdiff_t within = column % sweep.width;
  for (std::ptrdiff_t v = 0; v < kTileVectors; ++v) {
    found.begin[v] = count;
    std::ptrdiff_t lane = 0;
    while (lane < kLanes && column < sweep.columns) {
      const std::ptrdiff_t length =
          std::min({kLanes - lane, sweep.width - within, sweep.columns - column});
      found.runs[count++] = {lane, length, group * group_places + sweep.phase + within};
      lane += length;
      column += length;
      within += length;
      if (within == sweep.width) {
        within = 0;
        ++group;
      }
    }
  }
  found.begin[kTileVectors] = count;
  return found;
}

/// Asks for the columns of a row, moved by `offset`, to be brought into the second-level cache.
HWY_INLINE void prefetch_columns(const float* plane, const TileRuns& runs, std::ptrdiff_t offset) {
  constexpr int kNotForWriting = 0;
  constexpr int kSecondLevel = 2;
  for (std::ptrdiff_t i = 0; i < runs.begin[kTileVectors]; ++i) {
    const float* first = plane + runs.runs[i].place + offset;
    __builtin_prefetch(first, kNotForWriting, kSecondLevel);
    __builtin_prefetch(first + runs.runs[i].length - 1, kNotForWriting, kSecondLevel);
  }
}

/// The value that a convolution sees at `place`, also outside of the plane: zero in time order; in
/// segmented order the neighbouring segment's, as far as one segment away.
inline HWY_ATTR float value_at(const float* plane, const PlaneOrder& order, std::ptrdiff_t place) {
  const std::ptrdiff_t places = order.places();
  if (place >= 0 && place < places) return plane[place];
  if (order.segment == 0) return 0.0F;
  if (place < 0) {
    place += places - 1;
    return place < 0 || place % kSegments == kSegments - 1 ? 0.0F : plane[place];
  }
  place += 1 - places;
  return place >= places || place % kSegments == 0 ? 0.0F : plane[place];
}

/// Loads the columns of vector v, moved by `offset`, wherever they lie.
inline HWY_ATTR Vector gather_columns(const float* plane, const PlaneOrder& order,
                                      std::span<const Run> runs, std::ptrdiff_t offset) {
  const Lanes d;
  const std::ptrdiff_t places = order.places();
  if (runs.size() == 1 && runs[0].length == kLanes) {
    const std::ptrdiff_t place = runs[0].place + offset;
    if (place >= 0 && place + kLanes <= places) return hn::LoadU(d, plane + place);
    const bool outside = place + kLanes <= 0 || place >= places;
    if (outside && order.segment == 0) return hn::Zero(d);
  }
  HWY_ALIGN float columns[2 * kLanes];
  hn::Store(hn::Zero(d), d, columns);
  for (const Run& run : runs) {
    const std::ptrdiff_t place = run.place + offset;
    if (place >= 0 && place + kLanes <= places) {
      // Writes too far; the next run, or the space behind the vector, takes it.
      hn::StoreU(hn::LoadU(d, plane + place), d, columns + run.lane);
    } else {
      for (std::ptrdiff_t i = 0; i < run.length; ++i) {
        columns[run.lane + i] = value_at(plane, order, place + i);
      }
    }
  }
  return hn::Load(d, columns);
}

}  // namespace earpoint::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
