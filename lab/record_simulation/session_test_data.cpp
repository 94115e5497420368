#include "session_test_data.h"

#include <earpoint/scene/scene.h>

namespace earpoint {

std::shared_ptr<const PreparedScene> test_room(double absorption) {
  BandArray absorbs;
  BandArray scatters;
  absorbs.fill(static_cast<float>(absorption));
  scatters.fill(0.3F);
  Scene scene = make_shoebox({6.0, 5.0, 2.7}, absorbs, scatters);
  check_scene(scene, "room");
  return prepare_home("room", std::move(scene));
}

SessionPlan plan_of_two(const FigureLibrary& figures) {
  SessionPlan plan;
  plan.duration_s = 6.0;
  plan.world_from_camera = {look_at({1.0, 2.5, 1.5}, {3.0, 2.5, 1.5}),
                            look_at({3.0, 4.5, 1.5}, {3.0, 2.5, 1.5})};
  RandomStream random(1);
  for (int i = 0; i < 2; ++i) {
    SessionFigure person;
    person.name = i == 0 ? "person-1" : "person-2";
    person.figure = &figures.draw(i == 0 ? Gender::female : Gender::male, Posture::standing,
                                  FigureSplit::train, random);
    person.path = PersonPath({{3.0, i == 0 ? 1.5 : 3.5}, i == 0 ? kPi / 2.0 : -kPi / 2.0});
    person.microphone_m = {0.09, 0.0, -0.12};
    plan.people.push_back(std::move(person));
  }
  plan.clap_s = 0.5;
  plan.clap_m = {3.0, 2.5, 1.2};
  for (const char* name : {"1", "2", "person-1", "person-2"}) {
    plan.clocks.push_back({.name = name});
    plan.ends_s.push_back(plan.duration_s);
  }
  return plan;
}

}  // namespace earpoint
