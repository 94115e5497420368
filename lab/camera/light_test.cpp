#include "test_rooms.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include <earpoint/camera/scene_drawer.h>

namespace earpoint {
namespace {

constexpr Lighting kNoSky{.sky_radiance = {0.0F, 0.0F, 0.0F}, .light_dark_scenes = false};
constexpr Lighting kWhiteSky{.sky_radiance = {1.0F, 1.0F, 1.0F}, .light_dark_scenes = false};
constexpr RenderQuality kExact{.samples_per_side = 4, .denoise = false};

FloatImage radiance_of(const Scene& scene, const Camera& camera, const Lighting& lighting,
                       const RenderQuality& quality = kExact, std::uint64_t seed = 1) {
  ThreadPool pool(1);
  return SceneDrawer(scene, lighting, pool).radiance(camera, quality, seed, pool);
}

double mean(const FloatImage& picture) {
  const auto pixels = picture.pixels();
  return std::accumulate(pixels.begin(), pixels.end(), 0.0) / static_cast<double>(pixels.size());
}

// As a screen shows them: values above white count as white.
double root_mean_square(const FloatImage& a, const FloatImage& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    sum += std::pow(std::min(1.0F, a.pixels()[i]) - std::min(1.0F, b.pixels()[i]), 2);
  }
  return std::sqrt(sum / static_cast<double>(a.pixels().size()));
}

void paint(Scene& scene, const Look& look) {
  for (Material& material : scene.materials) material.look = look;
}

TEST(Furnace, ARoomThatShinesEverywhereIsUniform) {
  // Radiance = emission + reflectance * radiance everywhere.
  for (const float reflectance : {0.0F, 0.5F, 0.8F}) {
    Scene scene = make_shoebox({5, 4, 3}, all_bands(0.2F), all_bands(0.2F));
    Look look = plain_look(reflectance, reflectance, reflectance);
    look.emission = {0.3F, 0.3F, 0.3F};
    paint(scene, look);
    const Camera camera{
        .world_from_camera = look_at({1, 1, 1.5}, {4, 3, 1}), .width = 32, .height = 32};
    const FloatImage radiance = radiance_of(scene, camera, kNoSky);
    const double expected = 0.3 / (1.0 - reflectance);
    // The patches' 64 rays each are exact here, except for the 16 draws of direct light; over some
    // thousand patches and 16,000 samples the error of the mean is well below 1 %.
    EXPECT_NEAR(mean(radiance), expected, 0.01 * expected) << reflectance;
  }
}

TEST(Furnace, AnOutsideSkyGivesAConvexThingItsReflectance) {
  Scene scene;
  const int ball = add_ball(scene, "ball", {3, 0, 0}, 1.5, 96, plain_look(0.6F, 0.6F, 0.6F));
  const Camera camera{.width = 32, .height = 32};
  ThreadPool pool(1);
  const SceneDrawer drawer(scene, kWhiteSky, pool);
  const View view = drawer.draw(camera, kExact, 1, pool);
  const FloatImage radiance = drawer.radiance(camera, kExact, 1, pool);
  int checked = 0;
  for (int y = 1; y < 31; ++y) {
    for (int x = 1; x < 31; ++x) {
      bool inside = true;
      for (int k = 0; k < 9; ++k) {
        inside = inside && view.instance.at(x + k % 3 - 1, y + k / 3 - 1) == ball;
      }
      if (!inside) continue;
      ++checked;
      // Every ray that leaves the ball reaches the sky, except for the few that smooth normals send
      // below the flat triangle, which leans by up to 0.023 rad: at most one of a pixel's 16 is
      // lost.
      EXPECT_LE(radiance.at(x, y), 0.6001F);
      EXPECT_GE(radiance.at(x, y), 0.6F * 15 / 16 - 1e-4F);
    }
  }
  EXPECT_GT(checked, 150);
}

TEST(Lamp, LightFallsWithTheSquareOfDistanceAndTheCosine) {
  Scene scene;
  add_rectangle(scene, "floor", {-6, -6, 0}, {12, 0, 0}, {0, 12, 0}, plain_look(0.5F, 0.5F, 0.5F));
  scene.lamps.push_back({.position_m = {0, 0, 2}, .intensity = {3, 3, 3}, .radius_m = 0.01F});
  // From 4 m above, looking straight down; the picture's top is towards -x.
  const Camera camera{
      .world_from_camera = {{0, 0, 4}, quaternion_from_euler({.pitch_rad = -kPi / 2})},
      .width = 33,
      .height = 33};
  const FloatImage radiance = radiance_of(scene, camera, kNoSky);
  for (const int column : {16, 20, 26, 32}) {
    // A pixel is 8 m / 33 wide on the floor.
    const double aside_m = (column - 16) * 8.0 / 33;
    const double distance2 = 4.0 + aside_m * aside_m;
    const double expected = 0.5 / kPi * 3.0 / distance2 * (2.0 / std::sqrt(distance2));
    // A pixel averages over its width: the curvature there is below 2 %.
    EXPECT_NEAR(radiance.at(column, 16), expected, 0.02 * expected) << aside_m;
  }
}

TEST(ShiningSurface, LightsAFloorAsItsFormFactorSays) {
  // Under the middle of a square of side 2 a at height h, the irradiance of a radiance L is
  // 4 L a / sqrt(a^2 + h^2) * atan(a / sqrt(a^2 + h^2)) (Howell, Catalog of View Factors, C-11).
  Scene scene;
  Look shine = plain_look(0, 0, 0);
  shine.emission = {2, 2, 2};
  add_rectangle(scene, "panel", {-0.5, -0.5, 1.5}, {1, 0, 0}, {0, 1, 0}, shine);
  add_rectangle(scene, "floor", {-6, -6, 0}, {12, 0, 0}, {0, 12, 0}, plain_look(0.5F, 0.5F, 0.5F));
  const Camera camera{
      .world_from_camera = {{0, 0, 1}, quaternion_from_euler({.pitch_rad = -kPi / 2})},
      .horizontal_fov_rad = 0.02,
      .width = 8,
      .height = 8};
  const double slant = std::sqrt(0.25 + 2.25);
  const double irradiance = 4.0 * 2.0 * 0.5 / slant * std::atan(0.5 / slant);
  const double expected = 0.5 / kPi * irradiance;
  // 1024 samples with a deviation near 0.2 each: 3 standard deviations are 2 %.
  EXPECT_NEAR(mean(radiance_of(scene, camera, kNoSky)), expected, 0.02 * expected);
}

TEST(Shadow, FallsOnTheFarSideOfTheLamp) {
  Scene scene;
  add_rectangle(scene, "floor", {-6, -6, 0}, {12, 0, 0}, {0, 12, 0}, plain_look(0.5F, 0.5F, 0.5F));
  add_box(scene, "post", InstanceKind::furniture, {-0.1, -0.1, 0}, {0.1, 0.1, 1},
          plain_look(0.5F, 0.5F, 0.5F));
  scene.lamps.push_back({.position_m = {0, 2, 2}, .intensity = {3, 3, 3}, .radius_m = 0.02F});
  const Camera camera{
      .world_from_camera = {{0, 0, 4}, quaternion_from_euler({.pitch_rad = -kPi / 2})},
      .width = 65,
      .height = 65};
  // Left in the picture is +y, where the lamp hangs; the shadow lies to the right.
  const FloatImage radiance = radiance_of(scene, camera, kNoSky);
  EXPECT_LT(radiance.at(42, 32), 0.1F * radiance.at(22, 32));
  EXPECT_GT(radiance.at(42, 42), 0.5F * radiance.at(42, 22));  // no shadow beside it
  EXPECT_GT(radiance.at(42, 42), 10.0F * radiance.at(42, 32));
}

TEST(Shadow, OfAWiderLampIsSofter) {
  // Number of pixels across the edge of a wall's shadow that are neither light nor dark.
  const auto pixels_between = [](float radius_m) {
    const auto picture = [&](bool with_wall) {
      Scene scene;
      add_rectangle(scene, "floor", {-6, -6, 0}, {12, 0, 0}, {0, 12, 0},
                    plain_look(0.5F, 0.5F, 0.5F));
      if (with_wall) {
        add_rectangle(scene, "wall", {-3, 0, 0}, {6, 0, 0}, {0, 0, 1}, plain_look(0, 0, 0));
      }
      scene.lamps.push_back(
          {.position_m = {0, 1, 2}, .intensity = {3, 3, 3}, .radius_m = radius_m});
      const Camera camera{
          .world_from_camera = {{0, 0, 3}, quaternion_from_euler({.pitch_rad = -kPi / 2})},
          .width = 129,
          .height = 5};
      return radiance_of(scene, camera, kNoSky);
    };
    const FloatImage shadowed = picture(true);
    const FloatImage free = picture(false);
    int between = 0;
    for (int x = 66; x < 128; ++x) {
      const float share = shadowed.at(x, 2) / free.at(x, 2);
      if (share > 0.1F && share < 0.9F) ++between;
    }
    return between;
  };
  // The shadow ends at y = -1 m. The wall's top is half-way between there and the lamp, so that the
  // penumbra on the floor is the lamp's diameter over sin(45 degrees): 0.57 m and 0.057 m, in
  // pixels of 4.7 cm. 8 of its 12 pixels get 10 to 90 % of a disc's light.
  EXPECT_NEAR(pixels_between(0.2F), 10, 3);
  EXPECT_LE(pixels_between(0.02F), 2);
}

TEST(Noise, FallsWithSamples) {
  const Scene scene = furnished_room();
  const Camera camera{
      .world_from_camera = look_at({0.5, 0.6, 1.5}, {4.2, 3.0, 0.9}), .width = 48, .height = 48};
  const auto picture = [&](int side, bool denoise, std::uint64_t seed) {
    return radiance_of(scene, camera, kNoSky, {.samples_per_side = side, .denoise = denoise}, seed);
  };
  // Two pictures with different seeds differ by sqrt(2) of their noise. Independent samples would
  // halve it from 4 to 16 per pixel; evenly spread samples do better, edges of the texture worse.
  const double four = root_mean_square(picture(2, false, 1), picture(2, false, 2));
  const double sixteen = root_mean_square(picture(4, false, 1), picture(4, false, 2));
  EXPECT_LT(sixteen, 0.6 * four);
  EXPECT_GT(sixteen, 0.0);
}

TEST(Noise, SmoothingComesNearerToTheTruthAndKeepsTheMean) {
  const Scene scene = furnished_room();
  const Camera camera{
      .world_from_camera = look_at({0.5, 0.6, 1.5}, {4.2, 3.0, 0.9}), .width = 64, .height = 64};
  ThreadPool pool(1);
  const SceneDrawer drawer(scene, kNoSky, pool);
  const FloatImage truth =
      drawer.radiance(camera, {.samples_per_side = 16, .denoise = false}, 5, pool);
  const FloatImage raw = drawer.radiance(camera, {.denoise = false}, 1, pool);
  const FloatImage smooth = drawer.radiance(camera, {}, 1, pool);
  EXPECT_LT(root_mean_square(smooth, truth), 0.6 * root_mean_square(raw, truth));
  // The filter gives rare bright samples a little less weight than their share.
  EXPECT_NEAR(mean(smooth), mean(truth), 0.02 * mean(truth));
}

TEST(SeeThrough, APaneTakesItsOpacityOfTheLightBehind) {
  Scene scene;
  Look shine = plain_look(0, 0, 0);
  shine.emission = {1, 1, 1};
  const int wall = add_rectangle(scene, "wall", {4, -9, -9}, {0, 18, 0}, {0, 0, 18}, shine);
  Look glass = plain_look(0, 0, 0);
  glass.opacity = 0.3F;
  add_rectangle(scene, "pane", {2, -9, -9}, {0, 18, 0}, {0, 0, 18}, glass);
  const Camera camera{.width = 32, .height = 32};
  // 16 rays per pixel resolve opacity in steps of 1/16: at most half a step off, and the same in
  // every pixel.
  const FloatImage seen = radiance_of(scene, camera, kNoSky);
  EXPECT_NEAR(mean(seen), 0.7, 1.0 / 32.0);
  for (const float value : seen.pixels()) EXPECT_NEAR(value, mean(seen), 1e-5);
  // Depth and mask ignore a pane that is mostly see-through.
  const View view = SceneDrawer(scene).draw(camera, {}, 1);
  EXPECT_EQ(view.instance.at(5, 7), wall);
  // Single precision: 4 times a few 1e-7, and the ray's start moved off the pane.
  EXPECT_NEAR(view.depth_m.at(5, 7), 4.0F, 1e-5F);
}

TEST(SeeThrough, APaneThatIsMostlySolidIsSeen) {
  Scene scene;
  add_rectangle(scene, "wall", {4, -9, -9}, {0, 18, 0}, {0, 0, 18}, plain_look(1, 1, 1));
  Look milky = plain_look(0.5F, 0.5F, 0.5F);
  milky.opacity = 0.6F;
  const int pane = add_rectangle(scene, "pane", {2, -9, -9}, {0, 18, 0}, {0, 0, 18}, milky);
  const View view = SceneDrawer(scene).draw({.width = 32, .height = 32}, {}, 1);
  EXPECT_EQ(view.instance.at(5, 7), pane);
  // Single precision: 2 times a few 1e-7, and the ray's start moved off the pane.
  EXPECT_NEAR(view.depth_m.at(5, 7), 2.0F, 1e-5F);
}

TEST(Mirror, ShowsWhatIsBehindTheCameraTurnedRound) {
  Scene scene;
  const Look mirror{.base_colour = {0.9F, 0.9F, 0.9F}, .roughness = 0.0F, .metallic = 1.0F};
  const int glass = add_rectangle(scene, "mirror", {2, -9, -9}, {0, 18, 0}, {0, 0, 18}, mirror);
  Look red = plain_look(0, 0, 0);
  red.emission = {1, 0, 0};
  // Behind the camera, on its left.
  add_box(scene, "lantern", InstanceKind::furniture, {-2, 1, -0.5}, {-1.9, 3, 0.5}, red);
  const Camera camera{.width = 64, .height = 64};
  ThreadPool pool(1);
  const SceneDrawer drawer(scene, kNoSky, pool);
  const View view = drawer.draw(camera, kExact, 1, pool);
  EXPECT_EQ(view.instance.at(20, 32), glass);
  EXPECT_NEAR(view.depth_m.at(20, 32), 2.0F, 1e-5F);  // single precision, as above
  // Its image is 5.9 m away, 2 m to the left: column 32 - 32 * 2 / 5.9 = 21.
  const FloatImage radiance = drawer.radiance(camera, kExact, 1, pool);
  EXPECT_NEAR(radiance.at(21, 32, 0), 0.9F, 0.01F);  // Schlick's term adds a little off the axis
  EXPECT_EQ(radiance.at(43, 32, 0), 0.0F);
}

TEST(Texture, IsSeenUprightAndUnmirrored) {
  Scene scene;
  Image picture(8, 8, 3);
  for (int i = 0; i < 16; ++i) {
    picture.at(i % 4, i / 4, 0) = 255;          // red at the top left
    picture.at(4 + i % 4, 4 + i / 4, 2) = 255;  // blue at the bottom right
  }
  scene.textures.push_back(picture);
  // Seen from the origin, the wall's left end is at +y.
  add_rectangle(scene, "wall", {2, 1, -1}, {0, -2, 0}, {0, 0, 2},
                {.base_colour = {1, 1, 1}, .texture = 0, .roughness = 1.0F});
  const FloatImage radiance = radiance_of(scene, {.width = 64, .height = 64}, kWhiteSky);
  // The wall spans the middle half of the picture; its quarters' middles lie at 24 and 40. Sums of
  // single precision; mixing in a texel of another colour would take more.
  EXPECT_NEAR(radiance.at(24, 24, 0), 1.0F, 1e-3F);
  EXPECT_NEAR(radiance.at(40, 40, 2), 1.0F, 1e-3F);
  EXPECT_EQ(radiance.at(40, 24, 0), 0.0F);
  EXPECT_EQ(radiance.at(24, 40, 2), 0.0F);
}

TEST(Gloss, AShinyFloorMirrorsALampAndAMattOneDoesNot) {
  const auto highlight = [](float roughness) {
    Scene scene;
    add_rectangle(scene, "floor", {-9, -9, 0}, {18, 0, 0}, {0, 18, 0},
                  {.base_colour = {0.1F, 0.1F, 0.1F}, .roughness = roughness});
    scene.lamps.push_back({.position_m = {4, 0, 1}, .intensity = {1, 1, 1}, .radius_m = 0.1F});
    // The lamp's image lies 1 m under the floor, straight behind its own place.
    const Camera camera{.world_from_camera = look_at({0, 0, 1}, {4, 0, -1}),
                        .horizontal_fov_rad = 0.1,
                        .width = 9,
                        .height = 9};
    return mean(radiance_of(scene, camera, kNoSky));
  };
  EXPECT_GT(highlight(0.2F), 3.0 * highlight(0.9F));
  EXPECT_GT(highlight(0.1F), 3.0 * highlight(0.9F));
}

}  // namespace
}  // namespace earpoint
