#include "simplify.h"

#include "model_reader.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <vector>

#include <meshoptimizer.h>

namespace earpoint {
namespace {

constexpr float kLargestError = 0.1F;  ///< relative to the extent of the mesh

std::vector<std::uint32_t> indices_of(const Mesh& mesh, std::uint32_t material) {
  std::vector<std::uint32_t> indices;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.triangle_material[i] != material) continue;
    indices.insert(indices.end(), mesh.triangles[i].begin(), mesh.triangles[i].end());
  }
  return indices;
}

std::vector<std::uint32_t> simplified(const Mesh& mesh, const std::vector<std::uint32_t>& indices,
                                      double share, unsigned int options) {
  const std::size_t faces = indices.size() / 3;
  const auto wanted = static_cast<std::size_t>(static_cast<double>(faces) * share) * 3;
  std::vector<std::uint32_t> result(indices.size());
  result.resize(meshopt_simplify(
      result.data(), indices.data(), indices.size(), mesh.positions[0].data(),
      mesh.positions.size(), sizeof(mesh.positions[0]), wanted, kLargestError, options, nullptr));
  return result;
}

/// Gives every corner of every triangle a vertex of its own.
void part_vertices(Mesh& mesh) {
  Mesh parted;
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& v : triangle) {
      parted.positions.push_back(mesh.positions[v]);
      parted.normals.push_back(mesh.normals[v]);
      parted.uvs.push_back(mesh.uvs[v]);
      v = static_cast<std::uint32_t>(parted.positions.size() - 1);
    }
  }
  mesh.positions = std::move(parted.positions);
  mesh.normals = std::move(parted.normals);
  mesh.uvs = std::move(parted.uvs);
}

}  // namespace

void join_vertices(Mesh& mesh) {
  using Key = std::array<float, 8>;
  std::map<Key, std::uint32_t> known;
  Mesh joined;
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& v : triangle) {
      const auto& p = mesh.positions[v];
      const auto& n = mesh.normals[v];
      const auto& t = mesh.uvs[v];
      const Key key = {p[0], p[1], p[2], n[0], n[1], n[2], t[0], t[1]};
      const auto [entry, is_new] =
          known.try_emplace(key, static_cast<std::uint32_t>(joined.positions.size()));
      if (is_new) {
        joined.positions.push_back(p);
        joined.normals.push_back(n);
        joined.uvs.push_back(t);
      }
      v = entry->second;
    }
  }
  mesh.positions = std::move(joined.positions);
  mesh.normals = std::move(joined.normals);
  mesh.uvs = std::move(joined.uvs);
}

std::size_t drop_doubled_faces(Mesh& mesh) {
  std::map<std::array<float, 3>, std::uint32_t> places;
  std::set<std::array<std::uint32_t, 3>> known;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    std::array<std::uint32_t, 3> face{};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const auto next = static_cast<std::uint32_t>(places.size());
      face[corner] =
          places.try_emplace(mesh.positions[mesh.triangles[i][corner]], next).first->second;
    }
    std::sort(face.begin(), face.end());
    if (!known.insert(face).second) continue;
    mesh.triangles[kept] = mesh.triangles[i];
    mesh.triangle_material[kept] = mesh.triangle_material[i];
    mesh.triangle_instance[kept] = mesh.triangle_instance[i];
    ++kept;
  }
  const std::size_t dropped = mesh.triangles.size() - kept;
  mesh.triangles.resize(kept);
  mesh.triangle_material.resize(kept);
  mesh.triangle_instance.resize(kept);
  return dropped;
}

void simplify(Mesh& mesh, std::size_t most_triangles) {
  if (mesh.triangles.size() <= most_triangles) return;
  // Normals that change from face to face would keep every corner: they are removed and computed
  // again.
  std::fill(mesh.normals.begin(), mesh.normals.end(), std::array<float, 3>{});
  join_vertices(mesh);
  const std::uint32_t materials =
      *std::max_element(mesh.triangle_material.begin(), mesh.triangle_material.end()) + 1;
  // Locked borders limit some parts: first the others are reduced more, then borders are unlocked.
  double share = static_cast<double>(most_triangles) / static_cast<double>(mesh.triangles.size());
  std::vector<std::vector<std::uint32_t>> parts(materials);
  constexpr int kRounds = 6;
  for (int round = 0; round < kRounds; ++round) {
    const unsigned int options = round < kRounds / 2 ? meshopt_SimplifyLockBorder : 0;
    std::size_t triangles = 0;
    for (std::uint32_t material = 0; material < materials; ++material) {
      parts[material] = simplified(mesh, indices_of(mesh, material), share, options);
      triangles += parts[material].size() / 3;
    }
    if (triangles <= most_triangles) break;
    share *= 0.9 * static_cast<double>(most_triangles) / static_cast<double>(triangles);
  }
  mesh.triangles.clear();
  mesh.triangle_material.clear();
  for (std::uint32_t material = 0; material < materials; ++material) {
    for (std::size_t i = 0; i + 2 < parts[material].size(); i += 3) {
      mesh.triangles.push_back(
          {parts[material][i], parts[material][i + 1], parts[material][i + 2]});
      mesh.triangle_material.push_back(material);
    }
  }
  mesh.triangle_instance.assign(mesh.triangles.size(), 0);
  part_vertices(mesh);
  mend_normals(mesh);
  join_vertices(mesh);
}

}  // namespace earpoint
