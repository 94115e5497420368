#pragma once

#include <span>

#include <earpoint/vector3.h>

namespace earpoint {

constexpr int ambisonic_channels(int order) { return (order + 1) * (order + 1); }

/// The gains with which a plane wave is encoded: real spherical harmonics in the order of ACN, with
/// the norm N3D (the mean of each one's square over the sphere is 1; the first one is 1).
/// @param direction  unit length, to where the wave comes from, in the listener's frame
/// @param gains      shape [ambisonic_channels(order)]
/// Source: Nachbar, Zotter, Deleflie and Sontacchi, "AmbiX", Ambisonics Symposium 2011.
void encode_ambisonics(const Vector3& direction, int order, std::span<float> gains);

}  // namespace earpoint
