#include "body_outline.h"
#include "session_test_data.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/camera/scene_drawer.h>
#include <earpoint/record_simulation/session_pictures.h>
#include <earpoint/record_simulation/session_speech.h>

namespace earpoint {
namespace {

TEST(BodyOutline, IsWhatThePictureShowsWhereNothingHidesIt) {
  const auto room = test_room(0.5);
  const FigureLibrary figures;
  const SessionPlan plan = plan_of_two(figures);
  const PeopledScene peopled = scene_with_people(room->scene, plan, 0.0);
  // The camera at (1, 2.5): both people are in its picture, neither hides the other.
  const Camera camera{.world_from_camera = plan.world_from_camera[0], .width = 160, .height = 120};
  const View view = room->drawer.extended(peopled.scene).draw(camera, {.samples_per_side = 1}, 1);
  ASSERT_EQ(peopled.people.size(), 2U);
  for (const Person& person : peopled.people) {
    const auto outline = outline_of(peopled.scene, person.instance, camera);
    ASSERT_TRUE(outline);
    const auto visible = visible_box(view, static_cast<int>(person.instance), 1);
    ASSERT_TRUE(visible);
    // The picture has only the middles of pixels: an edge may be up to a pixel further out.
    EXPECT_NEAR(visible->x_min, outline->box.x_min, 1.01 / 160);
    EXPECT_NEAR(visible->x_max, outline->box.x_max, 1.01 / 160);
    EXPECT_NEAR(visible->y_min, outline->box.y_min, 1.01 / 120);
    EXPECT_NEAR(visible->y_max, outline->box.y_max, 1.01 / 120);
    const auto pixels = std::count(view.instance.pixels().begin(), view.instance.pixels().end(),
                                   static_cast<std::int32_t>(person.instance));
    // Middles on an edge may count either way.
    EXPECT_NEAR(static_cast<double>(pixels), outline->area, 0.01 * outline->area);
  }
}

TEST(BodyOutline, IsNothingBehindTheCamera) {
  const auto room = test_room(0.5);
  const FigureLibrary figures;
  const SessionPlan plan = plan_of_two(figures);
  const PeopledScene peopled = scene_with_people(room->scene, plan, 0.0);
  const Camera camera{.world_from_camera = look_at({3.0, 2.5, 1.5}, {3.0, 4.0, 1.5})};
  EXPECT_FALSE(outline_of(peopled.scene, peopled.people[0].instance, camera));
  EXPECT_TRUE(outline_of(peopled.scene, peopled.people[1].instance, camera));
}

TEST(SessionPictures, ChangeWhereSomebodyWalksAndStayWhereNobodyIs) {
  const auto room = test_room(0.5);
  const FigureLibrary figures;
  SessionPlan plan = plan_of_two(figures);
  plan.duration_s = 5.0;
  plan.ends_s.assign(4, 5.0);
  plan.clocks[1].offset_s = 1.0;
  const Stance from = plan.people[0].path.last();
  plan.people[0].path.add({.begin_s = 1.0,
                           .from = from.at,
                           .to = {4.2, 1.2},
                           .yaw_before_rad = from.yaw_rad,
                           .yaw_after_rad = 1.0});
  SilentProgress silent;
  const SessionPictureQuality quality{.width = 96, .height = 64, .samples_per_side = 1};
  const auto film = [&](int jobs) {
    std::vector<SessionFrame> frames;
    film_session(*room, plan, 1.0, quality, 1, jobs, silent,
                 [&](const SessionFrame& frame) { frames.push_back(frame); });
    return frames;
  };
  const std::vector<SessionFrame> frames = film(1);
  // The second camera begins a second later.
  ASSERT_EQ(frames.size(), 5U + 4U);
  const SessionFrame* first = nullptr;
  const SessionFrame* last = nullptr;
  for (const SessionFrame& frame : frames) {
    if (frame.camera != 0) continue;
    if (first == nullptr) first = &frame;
    last = &frame;
    ASSERT_EQ(frame.boxes.size(), 2U);
    for (const PersonBox& box : frame.boxes) EXPECT_GT(box.visible, 0.95);
  }
  EXPECT_EQ(last->frame, 4);
  // Seen from the camera at (1, 2.5), which looks along x, the first person is on the right and
  // walks away.
  const Box& before = first->boxes[0].box;
  const Box& after = last->boxes[0].box;
  EXPECT_GT(before.x_min, first->boxes[1].box.x_max);
  EXPECT_LT(after.y_max - after.y_min, before.y_max - before.y_min);
  // The picture changed where a person was and is. Outside of every region it is the same.
  const auto change = [&](double x, double y) {
    const int column = static_cast<int>(x * 96);
    const int row = static_cast<int>(y * 64);
    int sum = 0;
    for (int c = 0; c < 3; ++c) {
      sum += std::abs(first->rgb.at(column, row, c) - last->rgb.at(column, row, c));
    }
    return sum;
  };
  EXPECT_GT(change(0.5 * (before.x_min + before.x_max), 0.5 * (before.y_min + before.y_max)), 20);
  EXPECT_EQ(change(0.01, 0.01), 0);
  const std::vector<SessionFrame> again = film(2);
  ASSERT_EQ(again.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(again[i].camera, frames[i].camera);
    EXPECT_TRUE(std::ranges::equal(again[i].rgb.pixels(), frames[i].rgb.pixels()));
  }
}

}  // namespace
}  // namespace earpoint
