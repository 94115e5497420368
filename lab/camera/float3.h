#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <earpoint/vector3.h>

namespace earpoint {

constexpr float kPiF = 3.14159265F;

/// A point, a direction or a linear colour in single precision: what shading works with.
struct Float3 {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;

  Float3& operator+=(const Float3& b) {
    x += b.x;
    y += b.y;
    z += b.z;
    return *this;
  }
};

using Rgb = Float3;

constexpr Float3 operator+(const Float3& a, const Float3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
constexpr Float3 operator-(const Float3& a, const Float3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
constexpr Float3 operator-(const Float3& a) { return {-a.x, -a.y, -a.z}; }
constexpr Float3 operator*(const Float3& a, float s) { return {a.x * s, a.y * s, a.z * s}; }
/// Component by component: a colour through a filter.
constexpr Float3 operator*(const Float3& a, const Float3& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

constexpr float dot(const Float3& a, const Float3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Float3 cross(const Float3& a, const Float3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float norm(const Float3& a) { return std::sqrt(dot(a, a)); }
inline Float3 normalized(const Float3& a) { return a * (1.0F / norm(a)); }

constexpr float largest(const Float3& a) { return std::max(a.x, std::max(a.y, a.z)); }

/// Rec. 709 luminance of a linear colour.
constexpr float luminance(const Rgb& c) { return 0.2126F * c.x + 0.7152F * c.y + 0.0722F * c.z; }

inline Float3 float3(const Vector3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
constexpr Float3 float3(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

/// Two directions that form a right-handed orthonormal frame with a normal.
struct Frame {
  Float3 tangent;
  Float3 bitangent;
  Float3 normal;

  /// @param n  unit length
  /// Source: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6 (2017).
  explicit Frame(const Float3& n) : normal(n) {
    const float sign = std::copysign(1.0F, n.z);
    const float a = -1.0F / (sign + n.z);
    const float b = n.x * n.y * a;
    tangent = {1.0F + sign * n.x * n.x * a, sign * b, -sign * n.x};
    bitangent = {b, sign + n.y * n.y * a, -n.y};
  }

  [[nodiscard]] Float3 to_world(const Float3& local) const {
    return tangent * local.x + bitangent * local.y + normal * local.z;
  }
  [[nodiscard]] Float3 to_local(const Float3& world) const {
    return {dot(world, tangent), dot(world, bitangent), dot(world, normal)};
  }
};

}  // namespace earpoint
