#include "stand_in_maker.h"

#include <algorithm>
#include <cmath>

#include <earpoint/pose.h>

namespace earpoint {

void StandInMaker::build_seat() {
  const double arm = std::min(0.2, 0.14 * w_);
  const double seat_m = 0.42;
  const double back = 0.22;
  box(-d_ / 2, d_ / 2, -w_ / 2, w_ / 2, 0.06, 0.3, upholstery());
  box(-d_ / 2, -d_ / 2 + back, -w_ / 2 + arm, w_ / 2 - arm, 0.29, h_, upholstery());
  const int seats = std::max(1, static_cast<int>(std::lround((w_ - 2 * arm) / 0.65)));
  const double pitch = (w_ - 2 * arm) / seats;
  for (int i = 0; i < seats; ++i) {
    const double y = -w_ / 2 + arm + pitch * i;
    box(-d_ / 2 + back - 0.02, d_ / 2 - 0.01, y + 0.008, y + pitch - 0.008, 0.29, seat_m,
        upholstery());
  }
  for (const double side : {-1.0, 1.0}) {
    const double y = side * (w_ / 2 - arm / 2);
    box(-d_ / 2 + 0.01, d_ / 2 - 0.02, y - arm / 2, y + arm / 2, 0.08, 0.6, upholstery());
    const double c = side * (w_ / 2 - arm - 0.24);
    box(-d_ / 2 + back - 0.01, -d_ / 2 + back + 0.12, c - 0.2, c + 0.2, seat_m - 0.01,
        std::min(h_ - 0.02, seat_m + 0.36), cushion());
    if (w_ < 1.2) break;
  }
  legs(0.07, 0.05, 0.05, wood());
}

void StandInMaker::build_table(double top_m) {
  box(-d_ / 2, d_ / 2, -w_ / 2, w_ / 2, h_ - top_m, h_, wood());
  legs(h_ - top_m + 0.005, std::clamp(0.045 * w_, 0.04, 0.08), 0.03, wood());
}

void StandInMaker::build_chair() {
  const double seat_m = 0.46;
  box(-d_ / 2 + 0.02, d_ / 2, -w_ / 2, w_ / 2, seat_m - 0.05, seat_m, cushion());
  legs(seat_m - 0.04, 0.04, 0.01, wood());
  for (const double side : {-1.0, 1.0}) {
    const double y = side * (w_ / 2 - 0.03);
    box(-d_ / 2, -d_ / 2 + 0.035, y - 0.02, y + 0.02, seat_m - 0.045, h_, wood());
  }
  for (const double z : {h_ - 0.14, h_ - 0.3}) {
    box(-d_ / 2 + 0.008, -d_ / 2 + 0.027, -w_ / 2 + 0.04, w_ / 2 - 0.04, z, z + 0.1, wood());
  }
}

void StandInMaker::build_stool() {
  box(-d_ / 2, d_ / 2, -w_ / 2, w_ / 2, h_ - 0.08, h_, cushion());
  legs(h_ - 0.07, 0.045, 0.02, wood());
}

void StandInMaker::build_office_chair() {
  const double radius = std::min(d_, w_) / 2;
  builder_.add_cylinder({0, 0, 0}, radius * 0.95, radius * 0.2, 0.1, 10, plastic());
  builder_.add_cylinder({0, 0, 0.09}, 0.03, 0.03, 0.33, 10, metal());
  box(-d_ / 2 + 0.08, d_ / 2 - 0.03, -w_ / 2 + 0.06, w_ / 2 - 0.06, 0.4, 0.49, cushion());
  box(-d_ / 2 + 0.05, -d_ / 2 + 0.12, -w_ / 2 + 0.1, w_ / 2 - 0.1, 0.55, h_, cushion());
  box(-d_ / 2 + 0.02, -d_ / 2 + 0.06, -0.04, 0.04, 0.38, 0.7, plastic());
}

void StandInMaker::build_bed() {
  box(-d_ / 2 + 0.05, d_ / 2 - 0.02, -w_ / 2, w_ / 2, 0.12, 0.3, wood());
  box(-d_ / 2, -d_ / 2 + 0.06, -w_ / 2, w_ / 2, 0.0, h_, wood());
  box(-d_ / 2 + 0.07, d_ / 2 - 0.04, -w_ / 2 + 0.02, w_ / 2 - 0.02, 0.29, 0.48, linen());
  box(-d_ / 2 + 0.62, d_ / 2, -w_ / 2 - 0.0, w_ / 2, 0.26, 0.53, bedding());
  const int pillows = w_ > 1.2 ? 2 : 1;
  for (int i = 0; i < pillows; ++i) {
    const double pitch = w_ / pillows;
    const double y = -w_ / 2 + pitch * (i + 0.5);
    const double half = std::min(0.32, pitch / 2 - 0.05);
    box(-d_ / 2 + 0.1, -d_ / 2 + 0.5, y - half, y + half, 0.47, 0.6, linen());
  }
  legs(0.13, 0.06, 0.06, wood());
}

void StandInMaker::build_piano() {
  const Surface lacquer = flat("lacquer", "furniture_wood", {0.08F, 0.07F, 0.07F}, 0.25F);
  box(-d_ / 2, -d_ / 2 + 0.35, -w_ / 2, w_ / 2, 0.0, h_, lacquer);
  box(-d_ / 2 + 0.34, d_ / 2, -w_ / 2, w_ / 2, 0.6, 0.72, lacquer);
  box(-d_ / 2 + 0.4, d_ / 2 - 0.02, -w_ / 2 + 0.06, w_ / 2 - 0.06, 0.719, 0.735, white());
  for (const double side : {-1.0, 1.0}) {
    const double y = side * (w_ / 2 - 0.05);
    box(d_ / 2 - 0.08, d_ / 2 - 0.02, y - 0.03, y + 0.03, 0.0, 0.61, lacquer);
  }
}

}  // namespace earpoint
