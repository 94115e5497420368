#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <earpoint/scene/closure.h>
#include <earpoint/scene/ray_caster.h>

namespace earpoint {
namespace {

constexpr double kCell_m = 0.1;
constexpr int kMostCells = 1'000'000;
constexpr double kHeadroom_m = 1.8;        ///< a face with this much air below it covers a room
constexpr double kLargestIsland_m2 = 6.0;  ///< of furniture that reaches almost to the ceiling
constexpr double kLidGap_m = 1e-3;         ///< above the highest wall
constexpr double kRimOverlap_m = 0.01;     ///< of the rim's walls with the faces below
constexpr double kSkip_m = 1e-4;

/// Adds flat faces to a mesh, all of one material and instance.
struct FaceSink {
  Mesh& mesh;
  std::uint32_t material;
  std::uint32_t instance;

  void add(const std::array<Vector3, 4>& corners, const Vector3& normal) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vector3& p : corners) {
      mesh.positions.push_back(
          {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
      if (has_normals) {
        mesh.normals.push_back({static_cast<float>(normal.x), static_cast<float>(normal.y),
                                static_cast<float>(normal.z)});
      }
      if (has_uvs) mesh.uvs.push_back({static_cast<float>(p.x + p.z), static_cast<float>(p.y)});
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
    mesh.triangle_material.insert(mesh.triangle_material.end(), 2, material);
    mesh.triangle_instance.insert(mesh.triangle_instance.end(), 2, instance);
  }

  bool has_normals = !mesh.normals.empty();
  bool has_uvs = !mesh.uvs.empty();
};

/// A scene seen from above, cell by cell.
class LidMaker {
 public:
  LidMaker(const Scene& scene, const RayCaster& caster)
      : caster_(caster), box_(bounds(scene.mesh)) {
    const double width_m = box_.high.x - box_.low.x;
    const double depth_m = box_.high.y - box_.low.y;
    cell_m_ = std::max(kCell_m, std::sqrt(width_m * depth_m / kMostCells));
    // One ring of cells lies outside.
    columns_ = static_cast<int>(std::ceil(width_m / cell_m_)) + 2;
    rows_ = static_cast<int>(std::ceil(depth_m / cell_m_)) + 2;
    cells_.resize(static_cast<std::size_t>(columns_) * rows_);
    for (int j = 0; j < rows_; ++j) {
      for (int i = 0; i < columns_; ++i) look_down(i, j);
    }
    for (std::size_t i = 0; i < scene.mesh.positions.size(); ++i) {
      const Vector3 p = vertex(scene.mesh, static_cast<std::uint32_t>(i));
      Cell& cell = at(column_of(p.x), row_of(p.y));
      cell.highest_m = std::max(cell.highest_m, p.z);
    }
  }

  /// @return the area of the lids that were added, m2
  double make(FaceSink& faces) {
    fill_islands();
    double area_m2 = 0.0;
    for (int j = 0; j < rows_; ++j) {
      for (int i = 0; i < columns_; ++i) {
        if (!at(i, j).open || at(i, j).done) continue;
        const std::vector<int> part = connected(i, j);
        // Areas that are too small for a person are no rooms but gaps and cracks: no lid.
        if (static_cast<double>(part.size()) * cell_m_ * cell_m_ < 0.25) continue;
        area_m2 += static_cast<double>(part.size()) * cell_m_ * cell_m_;
        cover(part, faces);
      }
    }
    return area_m2;
  }

 private:
  struct Cell {
    bool open = false;  ///< a floor, and nothing overhead
    bool done = false;
    bool lid = false;                                             ///< of the current part
    double top_m = -std::numeric_limits<double>::infinity();      ///< first face from above
    double highest_m = -std::numeric_limits<double>::infinity();  ///< corner of a face
  };

  Cell& at(int i, int j) { return cells_[static_cast<std::size_t>(j) * columns_ + i]; }
  [[nodiscard]] bool exists(int i, int j) const {
    return i >= 0 && j >= 0 && i < columns_ && j < rows_;
  }
  [[nodiscard]] double x_of(int i) const { return box_.low.x + (i - 1) * cell_m_; }
  [[nodiscard]] double y_of(int j) const { return box_.low.y + (j - 1) * cell_m_; }
  [[nodiscard]] int column_of(double x) const {
    return std::clamp(static_cast<int>((x - box_.low.x) / cell_m_) + 1, 0, columns_ - 1);
  }
  [[nodiscard]] int row_of(double y) const {
    return std::clamp(static_cast<int>((y - box_.low.y) / cell_m_) + 1, 0, rows_ - 1);
  }

  /// Finds all faces on a vertical line, from above.
  void look_down(int i, int j) {
    Cell& cell = at(i, j);
    // Not exactly in the middle, where models often have edges.
    Vector3 from{x_of(i) + 0.47 * cell_m_, y_of(j) + 0.53 * cell_m_, box_.high.z + 1.0};
    bool first = true;
    bool covered = false;
    double above_m = 0.0;
    double passed_m = 0.0;
    for (int faces = 0; faces < 1000; ++faces) {
      const auto distance_m = caster_.distance_m(from, {0, 0, -1}, passed_m + kSkip_m);
      if (!distance_m) break;
      const double z = from.z - *distance_m;
      if (first) cell.top_m = z;
      if (!first && above_m - z >= kHeadroom_m) covered = true;
      first = false;
      above_m = z;
      passed_m = *distance_m;
    }
    cell.open = !first && !covered;
  }

  /// The connected cells around (i, j) that are open, or covered, like it.
  std::vector<int> connected(int i, int j) {
    const bool open = at(i, j).open;
    std::vector<int> part;
    std::vector<int> front = {j * columns_ + i};
    at(i, j).done = true;
    while (!front.empty()) {
      const int here = front.back();
      front.pop_back();
      part.push_back(here);
      const int x = here % columns_;
      const int y = here / columns_;
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        if (!exists(x + dx, y + dy)) continue;
        Cell& next = at(x + dx, y + dy);
        if (next.done || next.open != open) continue;
        next.done = true;
        front.push_back((y + dy) * columns_ + x + dx);
      }
    }
    return part;
  }

  /// Marks covered cells with open ones all around as open: they are tall furniture, not rooms.
  void fill_islands() {
    for (int j = 0; j < rows_; ++j) {
      for (int i = 0; i < columns_; ++i) {
        if (at(i, j).open || at(i, j).done) continue;
        const std::vector<int> part = connected(i, j);
        const bool reaches_rim = std::any_of(part.begin(), part.end(), [&](int cell) {
          return cell % columns_ == 0 || cell / columns_ == 0 || cell % columns_ == columns_ - 1 ||
                 cell / columns_ == rows_ - 1;
        });
        const double area_m2 = static_cast<double>(part.size()) * cell_m_ * cell_m_;
        if (reaches_rim || area_m2 > kLargestIsland_m2) continue;
        for (const int cell : part) cells_[static_cast<std::size_t>(cell)].open = true;
      }
    }
    for (Cell& cell : cells_) cell.done = false;
  }

  void cover(const std::vector<int>& part, FaceSink& faces) {
    for (Cell& cell : cells_) cell.lid = false;
    double lid_m = -std::numeric_limits<double>::infinity();
    // Extends the lid by one cell on every side, over the walls.
    for (const int cell : part) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int x = cell % columns_ + dx;
          const int y = cell / columns_ + dy;
          if (!exists(x, y)) continue;
          at(x, y).lid = true;
          lid_m = std::max({lid_m, at(x, y).highest_m, at(x, y).top_m});
        }
      }
    }
    lid_m += kLidGap_m;
    for (int j = 0; j < rows_; ++j) {
      for (int i = 0; i < columns_; ++i) {
        if (!at(i, j).lid) continue;
        add_rim(i, j, lid_m, faces);
        if (i > 0 && at(i - 1, j).lid) continue;
        int end = i;
        while (end < columns_ && at(end, j).lid) ++end;
        // Strips overlap a little, so that no ray passes between them.
        const double y1 = y_of(j + 1) + kLidGap_m;
        faces.add({Vector3{x_of(i), y_of(j), lid_m},
                   {x_of(i), y1, lid_m},
                   {x_of(end), y1, lid_m},
                   {x_of(end), y_of(j), lid_m}},
                  {0, 0, -1});
      }
    }
  }

  /// Walls from the lid down to what is below, where the lid ends.
  void add_rim(int i, int j, double z, FaceSink& faces) {
    const double bottom_m = at(i, j).top_m;
    const double low = std::isfinite(bottom_m) ? bottom_m - kRimOverlap_m : box_.low.z;
    if (low >= z) return;
    const double x0 = x_of(i);
    const double x1 = x_of(i + 1);
    const double y0 = y_of(j);
    const double y1 = y_of(j + 1);
    const auto is_rim = [&](int x, int y) { return !exists(x, y) || !at(x, y).lid; };
    const auto wall = [&](double ax, double ay, double bx, double by, const Vector3& normal) {
      faces.add({Vector3{ax, ay, low}, {bx, by, low}, {bx, by, z}, {ax, ay, z}}, normal);
    };
    if (is_rim(i - 1, j)) wall(x0, y0, x0, y1, {1, 0, 0});
    if (is_rim(i + 1, j)) wall(x1, y1, x1, y0, {-1, 0, 0});
    if (is_rim(i, j - 1)) wall(x1, y0, x0, y0, {0, 1, 0});
    if (is_rim(i, j + 1)) wall(x0, y1, x1, y1, {0, -1, 0});
  }

  const RayCaster& caster_;
  Bounds box_;
  double cell_m_ = kCell_m;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<Cell> cells_;
};

}  // namespace

double close_ceiling(Scene& scene, const Material& material) {
  const RayCaster caster(scene.mesh);
  LidMaker maker(scene, caster);
  FaceSink faces{scene.mesh, static_cast<std::uint32_t>(scene.materials.size()),
                 static_cast<std::uint32_t>(scene.instances.size())};
  const double area_m2 = maker.make(faces);
  if (area_m2 == 0.0) return 0.0;
  scene.materials.push_back(material);
  scene.instances.push_back({.name = "added ceiling", .kind = InstanceKind::structure});
  return area_m2;
}

}  // namespace earpoint
