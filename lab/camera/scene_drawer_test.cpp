#include "test_rooms.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

#include <earpoint/camera/scene_drawer.h>

namespace earpoint {
namespace {

const Look kGrey = plain_look(0.5F, 0.5F, 0.5F);
const Look kRed = plain_look(0.8F, 0.05F, 0.05F);

int count(const View& view, int instance) {
  return static_cast<int>(
      std::count(view.instance.pixels().begin(), view.instance.pixels().end(), instance));
}

bool same(const View& a, const View& b) {
  return std::ranges::equal(a.rgb.pixels(), b.rgb.pixels()) &&
         std::ranges::equal(a.depth_m.pixels(), b.depth_m.pixels()) &&
         std::ranges::equal(a.instance.pixels(), b.instance.pixels());
}

// A wall 4 m in front of the origin, to which tests add more.
Scene wall_in_front() {
  Scene scene;
  add_rectangle(scene, "wall", {4, -20, -20}, {0, 40, 0}, {0, 0, 40}, kGrey);
  return scene;
}

TEST(SceneDrawer, ThingsOnTheLeftAppearOnTheLeft) {
  Scene scene = wall_in_front();
  const int box = add_box(scene, "box", InstanceKind::furniture, {3, 1, -0.5}, {3.5, 2, 0.5}, kRed);
  const View view = SceneDrawer(scene).draw({}, {}, 1);
  int on_left = 0;
  int red_on_left = 0;
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      if (view.instance.at(x, y) != box) continue;
      ++on_left;
      EXPECT_LT(x, 128);
      if (view.rgb.at(x, y, 0) > 2 * view.rgb.at(x, y, 1)) ++red_on_left;
    }
  }
  EXPECT_GT(on_left, 1000);
  // Pixels on the outline mix with the wall.
  EXPECT_GT(red_on_left, on_left * 9 / 10);
}

TEST(SceneDrawer, OfSurfacesThatLieOnEachOtherTheLastOneIsSeen) {
  // The poster is 2 m wide; at a distance of 4 m the picture spans 8 m.
  const auto add_poster = [](Scene& scene) {
    return add_rectangle(scene, "poster", {4, -1, -1}, {0, 2, 0}, {0, 0, 2}, kRed);
  };
  Scene above = wall_in_front();
  const int poster = add_poster(above);
  EXPECT_EQ(count(SceneDrawer(above).draw({}, {}, 1), poster), 64 * 64);
  Scene below;
  const int hidden = add_poster(below);
  add_rectangle(below, "wall", {4, -20, -20}, {0, 40, 0}, {0, 0, 40}, kGrey);
  EXPECT_EQ(count(SceneDrawer(below).draw({}, {}, 1), hidden), 0);
}

TEST(SceneDrawer, ThingsAboveAppearAbove) {
  Scene scene = wall_in_front();
  const int box = add_box(scene, "box", InstanceKind::furniture, {3, -1, 1}, {3.5, 1, 2}, kRed);
  const View view = SceneDrawer(scene).draw({}, {}, 1);
  const auto visible = visible_box(view, box, 1);
  ASSERT_TRUE(visible);
  EXPECT_LT(visible->y_max, 0.5);
  EXPECT_LT(visible->x_min, 0.5);
  EXPECT_GT(visible->x_max, 0.5);
}

TEST(SceneDrawer, MaskCoversThePixelsThatTheProjectionSays) {
  // The front face of the box, 2 m ahead, spans y from -0.505 to 0.995 and z from -0.255 to 0.505:
  // with 128 pixels of focal length the columns 64.32 to 160.32 and the rows 95.68 to 144.32.
  Scene scene = wall_in_front();
  const int box = add_box(scene, "box", InstanceKind::furniture, {2, -0.505, -0.255},
                          {2.001, 0.995, 0.505}, kRed);
  const View view = SceneDrawer(scene).draw({}, {}, 1);
  EXPECT_EQ(visible_box(view, box, 1), (Box{64.0 / 256, 96.0 / 256, 160.0 / 256, 144.0 / 256}));
  EXPECT_EQ(count(view, box), (160 - 64) * (144 - 96));
}

TEST(SceneDrawer, FieldOfViewEndsAtTheEdgesOfThePicture) {
  // Seen at 90 degrees from 2 m, a wall 4 m wide fills the picture to the outermost pixel; an error
  // of half a pixel on a side would be seen.
  const double half_pixel_m = 2.0 / 128 / 2;
  for (const double spare_m : {0.5 * half_pixel_m, -1.5 * half_pixel_m}) {
    Scene scene;
    const double half_m = 2.0 + spare_m;
    const int wall = add_rectangle(scene, "wall", {2, -half_m, -half_m}, {0, 2 * half_m, 0},
                                   {0, 0, 2 * half_m}, kGrey);
    const View view = SceneDrawer(scene).draw({}, {}, 1);
    EXPECT_EQ(count(view, wall), spare_m > 0.0 ? 256 * 256 : 254 * 254);
  }
}

TEST(SceneDrawer, DepthIsMeasuredAlongTheAxis) {
  const View view = SceneDrawer(wall_in_front()).draw({.width = 64, .height = 48}, {}, 1);
  ASSERT_EQ(view.depth_m.pixels().size(), 64U * 48U);
  for (const float depth_m : view.depth_m.pixels()) {
    EXPECT_NEAR(depth_m, 4.0F, 4e-6F);  // single precision: 4 times a few 1e-7
  }
}

TEST(SceneDrawer, DepthOfABallIsThatOfTheClosedForm) {
  Scene scene;
  const Vector3 centre{3.0, 0.4, -0.2};
  constexpr double kRadiusM = 0.8;
  constexpr int kRings = 128;
  add_ball(scene, "ball", centre, kRadiusM, kRings, kGrey);
  const Camera camera{.width = 96, .height = 96};
  const View view = SceneDrawer(scene).draw(camera, {}, 1);
  int hits = 0;
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 96; ++x) {
      const Vector3 d = direction_of_pixel(camera, {x + 0.5, y + 0.5});
      const double b = dot(d, centre);
      const double c = dot(centre, centre) - kRadiusM * kRadiusM;
      const double inside = b * b - dot(d, d) * c;
      // Where the ray grazes the ball, flat triangles end earlier than the ball.
      if (std::abs(inside) < 0.05) continue;
      if (inside < 0.0) {
        EXPECT_TRUE(std::isinf(view.depth_m.at(x, y)));
        EXPECT_EQ(view.instance.at(x, y), View::kNoInstance);
        continue;
      }
      ++hits;
      // Triangles lie inside the ball by at most r (1 - cos(pi / rings)), twice for both angles,
      // which a slanted ray lengthens: by at most 1 / cos = 4 here.
      const double sag_m = 2.0 * kRadiusM * (1.0 - std::cos(kPi / kRings));
      EXPECT_NEAR(view.depth_m.at(x, y), (b - std::sqrt(inside)) / dot(d, d), 4.0 * sag_m);
    }
  }
  EXPECT_GT(hits, 500);
}

TEST(SceneDrawer, TakesAnyWorldPose) {
  // The same view from a camera at another place and yaw, with the scene moved in the same way.
  Scene scene;
  const Vector3 ahead = rotate(quaternion_from_euler({.yaw_rad = kPi / 2}), {2, 0, 0});
  const Vector3 at = Vector3{5, -3, 1.5} + ahead;
  const int box = add_box(scene, "box", InstanceKind::person, at - Vector3{0.5, 0.2, 0.5},
                          at + Vector3{0.25, 0.2, 1.0}, kRed);
  const Camera camera{.world_from_camera = look_at({5, -3, 1.5}, at)};
  const auto visible = visible_box(SceneDrawer(scene).draw(camera, {}, 1), box, 10);
  ASSERT_TRUE(visible);
  // Looking along +y, left is -x: the box reaches further left than right, and further up. Its
  // front is 1.8 m away: edges at 0.5 -+ size / 3.6, to a pixel.
  EXPECT_NEAR(visible->x_min, 0.5 - 0.5 / 3.6, 1.0 / 256);
  EXPECT_NEAR(visible->x_max, 0.5 + 0.25 / 3.6, 1.0 / 256);
  EXPECT_NEAR(visible->y_min, 0.5 - 1.0 / 3.6, 1.0 / 256);
  EXPECT_NEAR(visible->y_max, 0.5 + 0.5 / 3.6, 1.0 / 256);
}

TEST(SceneDrawer, GivesTheSameBytesForAnyNumberOfThreads) {
  const Scene scene = furnished_room();
  const Camera camera{
      .world_from_camera = look_at({0.5, 0.6, 1.5}, {4.2, 3.0, 0.9}), .width = 77, .height = 50};
  ThreadPool one(1);
  ThreadPool three(3);
  const SceneDrawer drawer_one(scene, {}, one);
  const SceneDrawer drawer_three(scene, {}, three);
  const View view = drawer_one.draw(camera, {}, 9, one);
  EXPECT_TRUE(same(view, drawer_three.draw(camera, {}, 9, three)));
  EXPECT_TRUE(same(view, drawer_three.draw(camera, {}, 9, one)));
  EXPECT_TRUE(same(view, drawer_one.draw(camera, {}, 9)));
  EXPECT_FALSE(same(view, drawer_one.draw(camera, {}, 10)));
}

TEST(SceneDrawer, TakesThePicturesOfTheDatasets) {
  const SceneDrawer drawer(furnished_room());
  const Pose pose = look_at({0.5, 0.6, 1.5}, {4.2, 3.0, 0.9});
  for (const auto& [width, height] : {std::pair{256, 256}, {384, 216}, {1, 1}, {3, 200}}) {
    const View view = drawer.draw({.world_from_camera = pose, .width = width, .height = height},
                                  {.samples_per_side = 1}, 1);
    EXPECT_EQ(view.rgb.width(), width);
    EXPECT_EQ(view.rgb.height(), height);
    EXPECT_EQ(view.rgb.channels(), 3);
    EXPECT_EQ(view.depth_m.width(), width);
    EXPECT_EQ(view.instance.height(), height);
  }
}

TEST(SceneDrawer, FindsAnExposureForDarkAndBrightRooms) {
  for (const float intensity : {0.01F, 1.0F, 100.0F}) {
    Scene scene = make_shoebox({5, 4, 2.6}, all_bands(0.2F), all_bands(0.2F));
    scene.lamps.push_back(
        {.position_m = {2.5, 2, 2.3}, .intensity = {intensity, intensity, intensity}});
    const View view = SceneDrawer(scene).draw(
        {.world_from_camera = look_at({0.5, 0.5, 1.5}, {4, 3, 1.2}), .width = 64, .height = 64}, {},
        1);
    double mean = 0.0;
    for (const std::uint8_t value : view.rgb.pixels()) mean += value / (64.0 * 64 * 3);
    EXPECT_GT(mean, 60.0) << intensity;
    EXPECT_LT(mean, 230.0) << intensity;
  }
}

TEST(SceneDrawer, ARegionHoldsThePixelsOfTheWholePicture) {
  Scene scene = wall_in_front();
  add_box(scene, "box", InstanceKind::furniture, {3, -1, -1}, {3.5, 1, 0.5}, kRed);
  const SceneDrawer drawer(scene);
  ThreadPool pool(1);
  const Camera camera{.width = 96, .height = 64};
  // Without denoising, which does not cross the region's edges.
  const RenderQuality quality{.samples_per_side = 2, .denoise = false};
  const View whole = drawer.draw(camera, quality, 5, pool);
  const PixelRegion region{.x = 24, .y = 16, .width = 41, .height = 30};
  const float exposure = drawer.found_exposure(camera, quality, 5, pool);
  const View part = drawer.draw_region(camera, region, quality, exposure, 5, pool);
  ASSERT_EQ(part.rgb.width(), region.width);
  ASSERT_EQ(part.rgb.height(), region.height);
  for (int y = 0; y < region.height; ++y) {
    for (int x = 0; x < region.width; ++x) {
      EXPECT_EQ(part.instance.at(x, y), whole.instance.at(region.x + x, region.y + y));
      // One step of 8 bits: rays are rounded differently because the corner of the view is computed
      // in another order.
      EXPECT_NEAR(part.rgb.at(x, y), whole.rgb.at(region.x + x, region.y + y), 1.0);
    }
  }
  EXPECT_THROW((void)drawer.draw_region(camera, {.x = 90, .width = 8, .height = 8}, quality,
                                        exposure, 5, pool),
               std::logic_error);
}

TEST(SceneDrawer, LightsASceneThatHasNoLight) {
  const Scene scene = make_shoebox({8, 4, 2.6}, all_bands(0.2F), all_bands(0.2F));
  const Camera camera{
      .world_from_camera = look_at({0.5, 0.5, 1.5}, {7, 3, 1.2}), .width = 32, .height = 32};
  ThreadPool pool(1);
  const FloatImage lit = SceneDrawer(scene).radiance(camera, {}, 1, pool);
  for (const float value : lit.pixels()) EXPECT_GT(value, 0.01F);
  const FloatImage dark =
      SceneDrawer(scene, {.light_dark_scenes = false}).radiance(camera, {}, 1, pool);
  for (const float value : dark.pixels()) EXPECT_EQ(value, 0.0F);
  // A black picture stays black.
  const View view = SceneDrawer(scene, {.light_dark_scenes = false}).draw(camera, {}, 1);
  EXPECT_EQ(*std::ranges::max_element(view.rgb.pixels()), 0);
}

/// A furnished room, and the same with a red box that stands in it.
struct RoomAndGuest {
  Scene room = furnished_room();
  Scene with_guest = room;
  int guest =
      add_box(with_guest, "guest", InstanceKind::person, {3.2, 1.6, 0.0}, {3.6, 2.1, 1.75}, kRed);
};

TEST(ExtendedRenderer, LightsWhatIsAddedAsAFreshRendererDoes) {
  const RoomAndGuest scenes;
  const Camera camera{
      .world_from_camera = look_at({0.8, 0.8, 1.5}, {3.6, 2.0, 1.0}), .width = 64, .height = 64};
  ThreadPool pool(1);
  const SceneDrawer fresh(scenes.with_guest);
  const SceneDrawer extended = SceneDrawer(scenes.room).extended(scenes.with_guest);
  const View fresh_view = fresh.draw(camera, {}, 1);
  const View extended_view = extended.draw(camera, {}, 1);
  EXPECT_TRUE(std::ranges::equal(fresh_view.depth_m.pixels(), extended_view.depth_m.pixels()));
  EXPECT_TRUE(std::ranges::equal(fresh_view.instance.pixels(), extended_view.instance.pixels()));
  ASSERT_GT(count(fresh_view, scenes.guest), 100);

  const FloatImage expected = fresh.radiance(camera, {.samples_per_side = 8}, 2, pool);
  const FloatImage found = extended.radiance(camera, {.samples_per_side = 8}, 2, pool);
  double on_guest = 0.0;
  double on_guest_expected = 0.0;
  double elsewhere = 0.0;
  double elsewhere_expected = 0.0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const bool is_guest = fresh_view.instance.at(x, y) == scenes.guest;
      (is_guest ? on_guest : elsewhere) += found.at(x, y, 0);
      (is_guest ? on_guest_expected : elsewhere_expected) += expected.at(x, y, 0);
    }
  }
  // Only the second and later bounces ignore that the guest darkens the room: some percent of the
  // light.
  EXPECT_NEAR(on_guest / on_guest_expected, 1.0, 0.05);
  EXPECT_NEAR(elsewhere / elsewhere_expected, 1.0, 0.05);
}

TEST(ExtendedRenderer, OfTheSceneItselfGivesTheSameBytes) {
  const Scene room = furnished_room();
  const Camera camera{
      .world_from_camera = look_at({0.8, 0.8, 1.5}, {3.6, 2.0, 1.0}), .width = 32, .height = 32};
  const SceneDrawer drawer(room);
  EXPECT_TRUE(same(drawer.extended(room).draw(camera, {}, 3), drawer.draw(camera, {}, 3)));
}

TEST(ExtendedRenderer, RefusesAnotherSceneAndNewLight) {
  const RoomAndGuest scenes;
  const SceneDrawer drawer(scenes.room);
  EXPECT_THROW(static_cast<void>(drawer.extended(wall_in_front())), std::logic_error);
  Scene other = scenes.with_guest;
  std::swap(other.mesh.triangles[0], other.mesh.triangles[1]);
  EXPECT_THROW(static_cast<void>(drawer.extended(other)), std::logic_error);
  Scene shining = scenes.with_guest;
  shining.materials.back().look.emission = {1.0F, 1.0F, 1.0F};
  EXPECT_THROW(static_cast<void>(drawer.extended(shining)), std::logic_error);
  Scene lamp = scenes.with_guest;
  lamp.lamps.push_back({.position_m = {1, 1, 1}, .intensity = {1, 1, 1}});
  EXPECT_THROW(static_cast<void>(drawer.extended(lamp)), std::logic_error);
}

TEST(SceneDrawer, RefusesQualityOutOfRange) {
  const SceneDrawer drawer(wall_in_front());
  EXPECT_THROW(static_cast<void>(drawer.draw({}, {.samples_per_side = 0}, 1)), std::logic_error);
  EXPECT_THROW(static_cast<void>(drawer.draw({}, {.exposure = 0.0F}, 1)), std::logic_error);
  EXPECT_THROW(static_cast<void>(drawer.draw({.width = 0}, {}, 1)), std::logic_error);
}

}  // namespace
}  // namespace earpoint
