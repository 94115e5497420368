#include <earpoint/generate/floor_map.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <utility>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kCell_m = 0.05;
constexpr double kMostCells = 1e6;
constexpr double kHeadroom_m = 1.95;
// Lower things can be stepped over: rugs, sills.
constexpr double kStep_m = 0.06;
constexpr double kSmallestPocketSquareMetres = 2.5;
// After a face, a ray continues this far behind it.
constexpr double kSkip_m = 1e-3;
// Thin upright surfaces (door leaves, walls of scans) are searched for at these heights.
constexpr std::array<double, 3> kLooks_m = {0.6, 1.1, 1.5};
// Clearance is measured up to this number of cells.
constexpr int kReach = 40;

/// The heights of all faces below a point, highest first.
std::vector<double> faces_below(const RayCaster& caster, const Vector3& from) {
  std::vector<double> heights_m;
  Vector3 at = from;
  while (const auto distance_m = caster.distance_m(at, {0, 0, -1})) {
    at.z -= *distance_m;
    heights_m.push_back(at.z);
    at.z -= kSkip_m;
  }
  return heights_m;
}

/// The faces with enough air above them and another face over that.
std::vector<double> floors_below(const std::vector<double>& faces_m) {
  std::vector<double> floors_m;
  for (std::size_t i = 1; i < faces_m.size(); ++i) {
    if (faces_m[i - 1] - faces_m[i] >= kHeadroom_m) floors_m.push_back(faces_m[i]);
  }
  return floors_m;
}

/// The most frequent floor height, to within the height of a step.
double commonest_floor(const std::vector<std::vector<double>>& floors_m) {
  std::map<long, std::size_t> counts;
  for (const auto& column : floors_m) {
    for (const double floor_m : column) ++counts[std::lround(floor_m / kStep_m)];
  }
  if (counts.empty()) return 0.0;
  const auto with_next = [&](const std::pair<const long, std::size_t>& entry) {
    const auto next = counts.find(entry.first + 1);
    return entry.second + (next == counts.end() ? 0 : next->second);
  };
  const auto best =
      std::max_element(counts.begin(), counts.end(),
                       [&](const auto& a, const auto& b) { return with_next(a) < with_next(b); });
  // The mean of the floors in these two steps.
  double sum_m = 0.0;
  std::size_t count = 0;
  for (const auto& column : floors_m) {
    for (const double floor_m : column) {
      const long step = std::lround(floor_m / kStep_m);
      if (step != best->first && step != best->first + 1) continue;
      sum_m += floor_m;
      ++count;
    }
  }
  return sum_m / static_cast<double>(count);
}

/// Calls visit(distance) for every face along a ray of that length.
template <typename Visit>
void for_faces_along(const RayCaster& caster, Vector3 at, const Vector3& direction, double length_m,
                     Visit visit) {
  double passed_m = 0.0;
  while (const auto distance_m = caster.distance_m(at, direction)) {
    passed_m += *distance_m;
    if (passed_m > length_m) return;
    visit(passed_m);
    passed_m += kSkip_m;
    at = at + (*distance_m + kSkip_m) * direction;
  }
}

}  // namespace

FloorMap::FloorMap(const Scene& scene, const RayCaster& caster) {
  choose_bounds(scene);
  look_down(caster, bounds(scene.mesh).high.z + 1.0);
  look_along(caster);
  drop_pockets();
  measure_clearance();
}

void FloorMap::choose_bounds(const Scene& scene) {
  const Bounds box = bounds(scene.mesh);
  const double width_m = box.high.x - box.low.x;
  const double depth_m = box.high.y - box.low.y;
  cell_m_ = std::max(kCell_m, std::sqrt(width_m * depth_m / kMostCells));
  x_min_ = box.low.x;
  y_min_ = box.low.y;
  columns_ = static_cast<int>(std::ceil(width_m / cell_m_)) + 1;
  rows_ = static_cast<int>(std::ceil(depth_m / cell_m_)) + 1;
}

FloorPoint FloorMap::middle(std::size_t cell) const {
  const std::size_t column = cell % columns_;
  const std::size_t row = cell / columns_;
  return {x_min_ + (static_cast<double>(column) + 0.5) * cell_m_,
          y_min_ + (static_cast<double>(row) + 0.5) * cell_m_};
}

std::optional<std::size_t> FloorMap::cell_at(const FloorPoint& point) const {
  const double column = std::floor((point.x - x_min_) / cell_m_);
  const double row = std::floor((point.y - y_min_) / cell_m_);
  if (!(column >= 0.0 && column < columns_ && row >= 0.0 && row < rows_)) return std::nullopt;
  return static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column);
}

double FloorMap::area_m2() const {
  return static_cast<double>(std::count(free_.begin(), free_.end(), 1)) * cell_m_ * cell_m_;
}

void FloorMap::look_down(const RayCaster& caster, double top_m) {
  std::vector<std::vector<double>> floors_m(cells());
  for (std::size_t cell = 0; cell < cells(); ++cell) {
    const FloorPoint at = middle(cell);
    floors_m[cell] = floors_below(faces_below(caster, {at.x, at.y, top_m}));
  }
  floor_m_ = commonest_floor(floors_m);
  free_.assign(cells(), 0);
  for (std::size_t cell = 0; cell < cells(); ++cell) {
    free_[cell] = std::any_of(floors_m[cell].begin(), floors_m[cell].end(), [&](double height_m) {
      return std::abs(height_m - floor_m_) <= kStep_m;
    });
  }
}

void FloorMap::look_along(const RayCaster& caster) {
  wall_x_.assign(cells(), 0);
  wall_y_.assign(cells(), 0);
  const auto mark = [&](int lines, int steps, bool along_x, std::vector<unsigned char>& walls) {
    for (int line = 0; line < lines; ++line) {
      const std::size_t first = along_x ? static_cast<std::size_t>(line) * columns_ : line;
      const FloorPoint start = middle(first);
      for (const double look_m : kLooks_m) {
        for_faces_along(caster, {start.x, start.y, floor_m_ + look_m},
                        along_x ? Vector3{1, 0, 0} : Vector3{0, 1, 0}, (steps - 1) * cell_m_,
                        [&](double distance_m) {
                          const auto step = std::min(static_cast<std::size_t>(distance_m / cell_m_),
                                                     static_cast<std::size_t>(steps) - 1);
                          walls[first + step * (along_x ? 1 : columns_)] = 1;
                        });
      }
    }
  };
  mark(rows_, columns_, true, wall_x_);
  mark(columns_, rows_, false, wall_y_);
}

void FloorMap::drop_pockets() {
  constexpr std::array<std::array<int, 2>, 4> kSides = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  std::vector<unsigned char> seen(cells(), 0);
  std::vector<std::size_t> pocket;
  for (std::size_t start = 0; start < cells(); ++start) {
    if (free_[start] == 0 || seen[start] != 0) continue;
    pocket.assign(1, start);
    seen[start] = 1;
    for (std::size_t i = 0; i < pocket.size(); ++i) {
      for (const auto& [dx, dy] : kSides) {
        if (!may_step(pocket[i], dx, dy)) continue;
        const std::size_t next = pocket[i] + static_cast<std::ptrdiff_t>(dy) * columns_ + dx;
        if (seen[next] != 0) continue;
        seen[next] = 1;
        pocket.push_back(next);
      }
    }
    if (static_cast<double>(pocket.size()) * cell_m_ * cell_m_ >= kSmallestPocketSquareMetres)
      continue;
    for (const std::size_t cell : pocket) free_[cell] = 0;
  }
}

std::vector<unsigned char> FloorMap::open_cells() const {
  // Cells beside a thin wall count as occupied.
  std::vector<unsigned char> open = free_;
  const auto close = [&](std::size_t cell, std::size_t next) {
    open[cell] = 0;
    if (next < cells()) open[next] = 0;
  };
  for (std::size_t cell = 0; cell < cells(); ++cell) {
    if (wall_x_[cell] != 0) close(cell, cell + 1);
    if (wall_y_[cell] != 0) close(cell, cell + columns_);
  }
  return open;
}

void FloorMap::measure_clearance() {
  const std::vector<unsigned char> open = open_cells();
  // Distance to the nearest obstacle within the row, from the left and from the right.
  std::vector<int> along(cells(), 0);
  for (int row = 0; row < rows_; ++row) {
    int* const line = &along[static_cast<std::size_t>(row) * columns_];
    const unsigned char* const is_open = &open[static_cast<std::size_t>(row) * columns_];
    for (int x = 0, steps = 0; x < columns_; ++x) {
      line[x] = steps = is_open[x] != 0 ? std::min(steps + 1, kReach) : 0;
    }
    for (int x = columns_ - 1, steps = 0; x >= 0; --x) {
      steps = is_open[x] != 0 ? std::min(steps + 1, kReach) : 0;
      line[x] = std::min(line[x], steps);
    }
  }
  clearance_cells_.assign(cells(), 0.0F);
  for (std::size_t cell = 0; cell < cells(); ++cell) {
    if (open[cell] == 0) continue;
    const int row = static_cast<int>(cell / columns_);
    int nearest = kReach * kReach;
    for (int step = -kReach; step <= kReach; ++step) {
      const bool inside = row + step >= 0 && row + step < rows_;
      const int side = inside ? along[cell + static_cast<std::ptrdiff_t>(step) * columns_] : 0;
      nearest = std::min(nearest, side * side + step * step);
    }
    // The obstacle may begin anywhere in its cell, and the point may lie anywhere in its own.
    clearance_cells_[cell] = std::max(0.0F, std::sqrt(static_cast<float>(nearest)) - 1.21F);
  }
}

double FloorMap::clearance_m(const FloorPoint& point) const {
  const auto cell = cell_at(point);
  return cell ? cell_m_ * static_cast<double>(clearance_cells_[*cell]) : 0.0;
}

std::optional<FloorPoint> FloorMap::draw(double clearance_m, RandomStream& random) const {
  EARPOINT_CHECK(clearance_m >= 0.0);
  std::vector<std::size_t> fitting;
  for (std::size_t cell = 0; cell < cells(); ++cell) {
    const double here_m = cell_m_ * static_cast<double>(clearance_cells_[cell]);
    if (here_m > 0.0 && here_m >= clearance_m) fitting.push_back(cell);
  }
  if (fitting.empty()) return std::nullopt;
  FloorPoint point = middle(fitting[random.index(fitting.size())]);
  point.x += cell_m_ * random.uniform(-0.5, 0.5);
  point.y += cell_m_ * random.uniform(-0.5, 0.5);
  return point;
}

bool FloorMap::may_step(std::size_t cell, int dx, int dy) const {
  const int column = static_cast<int>(cell % columns_) + dx;
  const int row = static_cast<int>(cell / columns_) + dy;
  if (column < 0 || column >= columns_ || row < 0 || row >= rows_) return false;
  if (free_[static_cast<std::size_t>(row) * columns_ + column] == 0) return false;
  if (dx != 0 && wall_x_[dx > 0 ? cell : cell - 1] != 0) return false;
  return dy == 0 || wall_y_[dy > 0 ? cell : cell - columns_] == 0;
}

std::vector<FloorPoint> FloorMap::within_walk(const FloorPoint& from, double longest_m) const {
  std::vector<FloorPoint> points;
  const auto start = cell_at(from);
  if (!start || free_[*start] == 0) return points;
  // Dijkstra over cells and their eight neighbours.
  const auto longest = static_cast<float>(longest_m / cell_m_);
  std::vector<float> walked(cells(), std::numeric_limits<float>::infinity());
  using Entry = std::pair<float, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto reach = [&](std::size_t cell, float length) {
    if (length > longest || length >= walked[cell]) return;
    walked[cell] = length;
    queue.emplace(length, cell);
  };
  reach(*start, 0.0F);
  while (!queue.empty()) {
    const auto [length, cell] = queue.top();
    queue.pop();
    if (length > walked[cell]) continue;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if ((dx == 0 && dy == 0) || !may_step(cell, dx, dy)) continue;
        const float step = dx != 0 && dy != 0 ? std::sqrt(2.0F) : 1.0F;
        reach(cell + static_cast<std::ptrdiff_t>(dy) * columns_ + dx, length + step);
      }
    }
  }
  for (std::size_t cell = 0; cell < cells(); ++cell) {
    if (std::isfinite(walked[cell])) points.push_back(middle(cell));
  }
  return points;
}

}  // namespace earpoint
