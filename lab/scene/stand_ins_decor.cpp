#include "stand_in_maker.h"

#include <algorithm>
#include <cmath>

#include <earpoint/pose.h>

namespace earpoint {

void StandInMaker::build_rug() {
  Surface pile = textured("rug", "rug_cotton", TexturePattern::rug, style_.rug, 1.0F);
  box(-d_ / 2, d_ / 2, -w_ / 2, w_ / 2, 0.0, h_ - 0.001, pile);
  builder_.add_quad({Vector3{-d_ / 2, -w_ / 2, h_}, Vector3{d_ / 2, -w_ / 2, h_},
                     Vector3{d_ / 2, w_ / 2, h_}, Vector3{-d_ / 2, w_ / 2, h_}},
                    pile, {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}});
}

void StandInMaker::build_lamp(double base_radius_m) {
  const double shade_m = std::min(0.3, 0.4 * h_);
  const double radius = std::min(d_, w_) / 2;
  builder_.add_cylinder({0, 0, 0}, base_radius_m, base_radius_m * 0.8, 0.03, 16, metal());
  builder_.add_cylinder({0, 0, 0.02}, 0.015, 0.015, h_ - shade_m, 8, metal());
  builder_.add_cylinder({0, 0, h_ - shade_m}, radius, radius * 0.65, shade_m, 16, shade());
}

void StandInMaker::build_ceiling_lamp() {
  const double radius = std::min(d_, w_) / 2;
  builder_.add_cylinder({0, 0, 0}, radius * 0.85, radius, h_ * 0.8, 20, shade());
  builder_.add_cylinder({0, 0, h_ * 0.7}, radius * 0.3, radius * 0.3, h_ * 0.299, 12, metal());
}

void StandInMaker::build_plant() {
  const double radius = std::min(d_, w_) / 2;
  const double pot_m = std::min(0.3, 0.35 * h_);
  const Surface pot = flat("pot", "ceramic_ware", {0.65F, 0.38F, 0.27F}, 0.7F);
  const Surface leaves =
      textured("leaves", "foliage", TexturePattern::foliage, {0.35F, 0.52F, 0.27F}, 0.9F);
  builder_.add_cylinder({0, 0, 0}, radius * 0.4, radius * 0.55, pot_m, 14, pot);
  // Leaves as tilted two-sided sheets round a stem.
  constexpr int kLeaves = 11;
  for (int i = 0; i < kLeaves; ++i) {
    const double turn = 2.399963 * i;  // the golden angle
    const double z0 = pot_m + (h_ - pot_m) * 0.45 * i / kLeaves;
    const double z1 = std::min(h_, z0 + (h_ - pot_m) * (0.5 + 0.05 * (i % 3)));
    const double reach = radius * (1.0 - 0.5 * i / kLeaves);
    const Vector3 out{std::cos(turn), std::sin(turn), 0.0};
    const Vector3 side{-0.22 * radius * out.y, 0.22 * radius * out.x, 0.0};
    const Vector3 base = Vector3{0, 0, z0} + 0.05 * radius * out;
    const Vector3 tip = Vector3{0, 0, z1} + reach * 0.95 * out;
    const Vector3 middle = 0.5 * (base + tip) + Vector3{0, 0, 0.12 * (z1 - z0)};
    builder_.add_quad({base, middle + side, tip, middle - side}, leaves,
                      {{{0, 0}, {0.5F, 0.5F}, {0, 1}, {-0.5F, 0.5F}}});
  }
}

void StandInMaker::build_computer() {
  box(-d_ / 2, -d_ / 2 + 0.16, -0.1, 0.1, 0.0, 0.015, plastic());
  box(-d_ / 2 + 0.03, -d_ / 2 + 0.05, -0.03, 0.03, 0.01, 0.2, plastic());
  box(-d_ / 2 + 0.049, -d_ / 2 + 0.075, -w_ / 2, w_ / 2, 0.08, h_, screen());
  box(d_ / 2 - 0.16, d_ / 2 - 0.02, -0.21, 0.21, 0.0, 0.018, plastic());
}

void StandInMaker::build_television() {
  box(-d_ / 2, d_ / 2, -0.25 * w_, 0.25 * w_, 0.0, 0.02, plastic());
  box(-0.03, 0.01, -0.06, 0.06, 0.015, 0.12, plastic());
  box(0.0, 0.04, -w_ / 2, w_ / 2, 0.08, h_, screen());
}

void StandInMaker::build_radiator() {
  const int ribs = std::max(4, static_cast<int>(w_ / 0.07));
  for (int i = 0; i < ribs; ++i) {
    const double y = -w_ / 2 + w_ * (i + 0.5) / ribs;
    box(-d_ / 2 + 0.02, d_ / 2, y - 0.4 * w_ / ribs, y + 0.4 * w_ / ribs, 0.0, h_, white());
  }
  box(-d_ / 2 + 0.035, d_ / 2 - 0.015, -w_ / 2 + 0.01, w_ / 2 - 0.01, 0.04, 0.09, white());
  box(-d_ / 2 + 0.035, d_ / 2 - 0.015, -w_ / 2 + 0.01, w_ / 2 - 0.01, h_ - 0.09, h_ - 0.04,
      white());
}

void StandInMaker::build_curtain() {
  const Surface cloth =
      textured("curtain", style_.curtain_sound, TexturePattern::curtain, style_.curtain, 0.9F);
  const int folds = std::max(2, static_cast<int>(w_ / 0.14));
  const int steps = folds * 6;
  Mesh sheet;
  for (int i = 0; i <= steps; ++i) {
    const double phase = 2.0 * kPi * i / 6.0;
    const double slope = 0.8 * std::cos(phase);
    for (int j = 0; j < 2; ++j) {
      sheet.positions.push_back({static_cast<float>(0.45 * d_ * std::sin(phase)),
                                 static_cast<float>(-w_ / 2 + w_ * i / steps),
                                 static_cast<float>(j * h_)});
      const Vector3 normal = normalized(Vector3{1.0, -slope, 0.0});
      sheet.normals.push_back({static_cast<float>(normal.x), static_cast<float>(normal.y), 0.0F});
      sheet.uvs.push_back({static_cast<float>(i) / 36.0F, static_cast<float>(j)});
    }
  }
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(steps); ++i) {
    sheet.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    sheet.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
  }
  sheet.triangle_material.assign(sheet.triangles.size(), 0);
  builder_.add_mesh(sheet, {cloth});
}

void StandInMaker::build_blinds() {
  // One sheet, as the table's absorption is that of slats and gaps together.
  const Surface slats =
      textured("slats", "blinds", TexturePattern::blinds, {0.88F, 0.87F, 0.83F}, 0.7F);
  const auto top = static_cast<float>(h_);
  builder_.add_quad({Vector3{0, -w_ / 2, 0}, Vector3{0, w_ / 2, 0}, Vector3{0, w_ / 2, h_},
                     Vector3{0, -w_ / 2, h_}},
                    slats, {{{0, 0}, {1, 0}, {1, top}, {0, top}}});
}

void StandInMaker::build_framed(Surface picture) {
  box(-d_ / 2, d_ / 2 - 0.004, -w_ / 2, w_ / 2, 0.0, h_, wood());
  front_picture(0.0, h_, 0.025, picture);
}

}  // namespace earpoint
