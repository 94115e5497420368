#pragma once

#include <earpoint/scene/people.h>

namespace earpoint {

/// A person built of ellipsoids and tapered cylinders, with the sizes of an adult: about 1.64 m
/// (female) or 1.77 m (male) tall when standing.
FigureModel make_mannequin(Gender gender, Posture posture);

/// Puts a stool under a sitting figure, at its `seat_m`; leaves others as they are.
void add_stool(FigureModel& figure);

/// The height of a seat's top under a sitting mannequin, metres.
constexpr double kSeat_m = 0.45;

}  // namespace earpoint
