#include "stand_in_maker.h"

#include <algorithm>
#include <cmath>

#include <earpoint/pose.h>

namespace earpoint {

void StandInMaker::build_cupboard(int columns, int rows, Surface body) {
  box(-d_ / 2, d_ / 2 - 0.02, -w_ / 2, w_ / 2, 0.0, h_, body);
  const double bottom = std::min(0.08, 0.1 * h_);
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      const double y0 = -w_ / 2 + w_ * i / columns + 0.004;
      const double y1 = -w_ / 2 + w_ * (i + 1) / columns - 0.004;
      const double z0 = bottom + (h_ - bottom) * j / rows + 0.004;
      const double z1 = bottom + (h_ - bottom) * (j + 1) / rows - 0.004;
      box(d_ / 2 - 0.021, d_ / 2 - 0.004, y0, y1, z0, z1, body);
      const double y = rows > 1 ? (y0 + y1) / 2 : (i % 2 == 0 ? y1 - 0.05 : y0 + 0.05);
      const double z = (z0 + z1) / 2;
      const double high = rows > 1 ? 0.006 : std::min(0.08, (z1 - z0) / 4);
      const double wide = rows > 1 ? 0.06 : 0.006;
      box(d_ / 2 - 0.005, d_ / 2, y - wide, y + wide, z - high, z + high, metal());
    }
  }
}

void StandInMaker::build_bookcase() {
  box(-d_ / 2, d_ / 2 - 0.005, -w_ / 2, w_ / 2, 0.0, h_, panel());
  front_picture(0.0, h_, 0.03,
                textured("books", "furniture_wood", TexturePattern::books, style_.wood));
}

void StandInMaker::build_kitchen_base(bool sink, bool stove) {
  const double top = h_ - 0.04;
  box(-d_ / 2, d_ / 2 - 0.05, -w_ / 2, w_ / 2, 0.08, top, wood());
  box(-d_ / 2, d_ / 2 - 0.08, -w_ / 2, w_ / 2, 0.0, 0.09, plastic());
  const int doors = std::max(1, static_cast<int>(std::lround(w_ / 0.55)));
  for (int i = 0; i < doors && !stove; ++i) {
    const double y0 = -w_ / 2 + w_ * i / doors + 0.004;
    const double y1 = -w_ / 2 + w_ * (i + 1) / doors - 0.004;
    box(d_ / 2 - 0.051, d_ / 2 - 0.03, y0, y1, 0.1, top - 0.01, wood());
    box(d_ / 2 - 0.031, d_ / 2 - 0.02, y0 + 0.05, y1 - 0.05, top - 0.07, top - 0.055, metal());
  }
  if (stove) {
    box(d_ / 2 - 0.051, d_ / 2 - 0.03, -w_ / 2 + 0.02, w_ / 2 - 0.02, 0.1, top - 0.12, screen());
    box(d_ / 2 - 0.051, d_ / 2 - 0.035, -w_ / 2 + 0.02, w_ / 2 - 0.02, top - 0.11, top - 0.01,
        metal());
  }
  box(-d_ / 2, d_ / 2, -w_ / 2, w_ / 2, top - 0.001, h_ - 0.004, stone());
  if (stove) box(-d_ / 2 + 0.08, d_ / 2 - 0.08, -w_ / 2 + 0.04, w_ / 2 - 0.04, top, h_, screen());
  if (sink) {
    box(-d_ / 2 + 0.12, d_ / 2 - 0.1, -w_ / 2 + 0.15, w_ / 2 - 0.15, top, h_ - 0.002, metal());
    builder_.add_cylinder({-d_ / 2 + 0.07, 0, h_ - 0.01}, 0.014, 0.014, 0.009, 10, metal());
  }
}

void StandInMaker::build_fridge() {
  box(-d_ / 2, d_ / 2 - 0.06, -w_ / 2, w_ / 2, 0.0, h_, white());
  const double gap = 0.66 * h_;
  box(d_ / 2 - 0.058, d_ / 2 - 0.03, -w_ / 2, w_ / 2, 0.03, gap - 0.005, white());
  box(d_ / 2 - 0.058, d_ / 2 - 0.03, -w_ / 2, w_ / 2, gap + 0.005, h_ - 0.005, white());
  box(d_ / 2 - 0.031, d_ / 2, -w_ / 2 + 0.04, -w_ / 2 + 0.06, gap - 0.4, gap - 0.05, metal());
  box(d_ / 2 - 0.031, d_ / 2, -w_ / 2 + 0.04, -w_ / 2 + 0.06, gap + 0.05, gap + 0.3, metal());
}

void StandInMaker::build_washing_machine() {
  box(-d_ / 2, d_ / 2 - 0.03, -w_ / 2, w_ / 2, 0.0, h_, white());
  box(d_ / 2 - 0.031, d_ / 2, -w_ / 2 + 0.12, w_ / 2 - 0.12, 0.28, 0.64, screen());
  box(d_ / 2 - 0.031, d_ / 2 - 0.01, -w_ / 2 + 0.03, w_ / 2 - 0.03, h_ - 0.14, h_ - 0.03,
      plastic());
}

void StandInMaker::build_bathtub() {
  const double rim = 0.09;
  box(-d_ / 2, d_ / 2, -w_ / 2, w_ / 2, 0.0, 0.14, ceramic());
  box(-d_ / 2, -d_ / 2 + rim, -w_ / 2, w_ / 2, 0.13, h_, ceramic());
  box(d_ / 2 - rim, d_ / 2, -w_ / 2, w_ / 2, 0.13, h_, ceramic());
  box(-d_ / 2 + rim, d_ / 2 - rim, -w_ / 2, -w_ / 2 + rim, 0.13, h_, ceramic());
  box(-d_ / 2 + rim, d_ / 2 - rim, w_ / 2 - rim, w_ / 2, 0.13, h_, ceramic());
}

void StandInMaker::build_toilet() {
  box(-d_ / 2, -d_ / 2 + 0.2, -w_ / 2, w_ / 2, 0.36, h_, ceramic());
  const double radius = std::min(w_ / 2, 0.2);
  builder_.add_cylinder({d_ / 2 - radius - 0.04, 0, 0}, radius * 0.6, radius, 0.39, 16, ceramic());
  box(-d_ / 2 + 0.02, d_ / 2 - 0.24, -0.12, 0.12, 0.0, 0.385, ceramic());
  builder_.add_cylinder({d_ / 2 - radius - 0.03, 0, 0.391}, radius, radius, 0.03, 16, white());
}

void StandInMaker::build_washbasin() {
  box(-d_ / 2, d_ / 2 - 0.06, -w_ / 2 + 0.04, w_ / 2 - 0.04, 0.0, h_ - 0.15, wood());
  box(-d_ / 2, d_ / 2, -w_ / 2, w_ / 2, h_ - 0.16, h_ - 0.03, ceramic());
  builder_.add_cylinder({-d_ / 2 + 0.07, 0, h_ - 0.04}, 0.018, 0.014, 0.04, 10, metal());
}

}  // namespace earpoint
