#include <set>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/scene/homes.h>
#include <earpoint/scene/model_pack.h>
#include <earpoint/scene/people.h>
#include <earpoint/scene/ray_caster.h>

namespace earpoint {
namespace {

/// What must hold for every figure, from any source.
void expect_speaks_forward(const FigureModel& figure) {
  SCOPED_TRACE(figure.name + ", " + std::string(name_of(figure.posture)));
  const Bounds box = bounds(figure.scene.mesh);
  // Floats of some metres.
  EXPECT_NEAR(box.low.z, 0.0, 1e-4);
  EXPECT_NEAR(norm(box.high - box.low - figure.size_m), 0.0, 1e-4);
  const double above_mouth_m = box.high.z - figure.mouth_m.z;
  EXPECT_GT(above_mouth_m, 0.12);
  EXPECT_LT(above_mouth_m, 0.28);
  // The origin is below the middle of the head. The lips are some 9 cm ahead of it, the mouth 2 cm
  // more.
  EXPECT_NEAR(figure.mouth_m.x, 0.11, 0.025);
  EXPECT_NEAR(figure.mouth_m.y, 0.0, 0.02);
  // Ahead of the mouth is free air for at least an arm's length; behind it are the lips, or the
  // throat of figures with an open mouth.
  const RayCaster body(figure.scene.mesh);
  const auto ahead_m = body.distance_m(figure.mouth_m, {1, 0, 0});
  EXPECT_TRUE(!ahead_m || *ahead_m > 0.4);
  const auto behind_m = body.distance_m(figure.mouth_m, {-1, 0, 0});
  ASSERT_TRUE(behind_m);
  EXPECT_GT(*behind_m, 0.005);
  EXPECT_LT(*behind_m, 0.21);
  // Most of the head is behind the lips.
  const auto from_behind_m = body.distance_m(figure.mouth_m - Vector3{0.5, 0, 0}, {1, 0, 0});
  ASSERT_TRUE(from_behind_m);
  EXPECT_LT(*from_behind_m, 0.45);
}

TEST(Mannequin, HasTheSizesOfAnAdult) {
  const FigureLibrary library;
  RandomStream random(1);
  const auto figure = [&](Gender gender, Posture posture) -> const FigureModel& {
    return library.draw(gender, posture, FigureSplit::train, random);
  };
  // Mean heights of adults in Europe, to within a hand's breadth.
  EXPECT_NEAR(figure(Gender::female, Posture::standing).size_m.z, 1.64, 0.06);
  EXPECT_NEAR(figure(Gender::male, Posture::standing).size_m.z, 1.77, 0.06);
  EXPECT_NEAR(figure(Gender::male, Posture::sitting).size_m.z, 1.33, 0.08);
  EXPECT_NEAR(figure(Gender::male, Posture::ground).size_m.z, 0.91, 0.08);
}

TEST(Mannequin, SpeaksForward) {
  const FigureLibrary library;
  RandomStream random(1);
  for (const Gender gender : {Gender::female, Gender::male}) {
    for (const Posture posture : {Posture::standing, Posture::sitting, Posture::ground}) {
      expect_speaks_forward(library.draw(gender, posture, FigureSplit::train, random));
    }
  }
}

TEST(InstalledFigures, SpeakForward) {
  const ModelPack pack = installed_models();
  if (pack.figures.empty()) GTEST_SKIP() << "no models are installed; ./dev assets does it";
  for (const FigureModel& figure : pack.figures) expect_speaks_forward(figure);
}

TEST(InstalledFigures, StandOrSitAsPeopleDo) {
  const ModelPack pack = installed_models();
  if (pack.figures.empty()) GTEST_SKIP() << "no models are installed; ./dev assets does it";
  std::set<std::pair<Gender, bool>> standing;
  for (const FigureModel& figure : pack.figures) {
    SCOPED_TRACE(figure.name);
    if (figure.posture == Posture::standing) {
      standing.emplace(figure.gender, figure.for_test);
      EXPECT_GT(figure.size_m.z, 1.5);
      EXPECT_LT(figure.size_m.z, 1.95);
    }
    if (figure.posture == Posture::sitting) {
      EXPECT_GT(figure.seat_m, 0.3);
      EXPECT_LT(figure.seat_m, 0.65);
    }
    EXPECT_LE(figure.scene.mesh.triangles.size(), 12'000U);
    EXPECT_FALSE(figure.credit.empty());
  }
  EXPECT_EQ(standing.size(), 4U) << "a woman and a man for training, others for tests";
}

FigureModel figure_named(const std::string& name, bool for_test) {
  RandomStream random(1);
  FigureModel figure =
      FigureLibrary().draw(Gender::female, Posture::standing, FigureSplit::train, random);
  figure.name = name;
  figure.for_test = for_test;
  return figure;
}

TEST(FigureLibrary, KeepsTestFiguresOutOfTraining) {
  const FigureLibrary library(
      {figure_named("a", false), figure_named("b", true), figure_named("c", false)});
  std::set<std::string> train;
  std::set<std::string> test;
  RandomStream random(3);
  for (int i = 0; i < 50; ++i) {
    train.insert(library.draw(Gender::female, Posture::standing, FigureSplit::train, random).name);
    test.insert(library.draw(Gender::female, Posture::standing, FigureSplit::test, random).name);
  }
  EXPECT_EQ(train, (std::set<std::string>{"a", "c"}));
  EXPECT_EQ(test, (std::set<std::string>{"b"}));
}

TEST(FigureLibrary, HasAStandInWhereNoFigureFits) {
  const FigureLibrary library({figure_named("a", false)});
  RandomStream random(3);
  EXPECT_EQ(library.draw(Gender::male, Posture::standing, FigureSplit::train, random).name,
            "male mannequin");
  EXPECT_EQ(library.draw(Gender::female, Posture::standing, FigureSplit::test, random).name,
            "female mannequin");
}

TEST(FigureLibrary, LetsSomebodyStandWhereNobodySits) {
  const FigureLibrary library({figure_named("a", false)});
  RandomStream random(3);
  const FigureModel& figure =
      library.draw(Gender::female, Posture::sitting, FigureSplit::train, random);
  EXPECT_EQ(figure.name, "a");
  EXPECT_EQ(figure.posture, Posture::standing);
}

TEST(FigureLibrary, LetsPeopleSitLowerOrHigherBeforeTheyStand) {
  RandomStream random(3);
  const auto posture_drawn = [&](std::vector<Posture> there, Posture wanted) {
    std::vector<FigureModel> models;
    for (const Posture posture : there) {
      models.push_back(figure_named("a", true));
      models.back().posture = posture;
    }
    const FigureLibrary library(std::move(models));
    return library.draw(Gender::female, wanted, FigureSplit::test, random).posture;
  };
  using enum Posture;
  EXPECT_EQ(posture_drawn({standing, ground}, sitting), ground);
  EXPECT_EQ(posture_drawn({standing, sitting}, ground), sitting);
  EXPECT_EQ(posture_drawn({sitting, ground}, standing), sitting) << "no stand-in among real people";
}

TEST(FigureLibrary, DrawsAdultsAlone) {
  FigureModel girl = figure_named("girl", false);
  girl.is_adult = false;
  const FigureLibrary library({girl, figure_named("woman", false)});
  RandomStream random(3);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(library.draw(Gender::female, Posture::standing, FigureSplit::train, random).name,
              "woman");
  }
  EXPECT_EQ(FigureLibrary({girl})
                .draw(Gender::female, Posture::standing, FigureSplit::train, random)
                .name,
            "female mannequin");
}

TEST(AddPerson, PutsMouthAndBodyWhereTheyAreSaidToBe) {
  Home home = make_home(2, {}, FurnitureLibrary());
  const std::size_t faces = home.scene.mesh.triangles.size();
  RandomStream random(1);
  const FigureLibrary library;
  const FigureModel& figure =
      library.draw(Gender::male, Posture::standing, FigureSplit::train, random);
  const double yaw_rad = radians_from_degrees(120.0);
  const Person person = add_person(figure, 2.0, 1.5, yaw_rad, home.scene);
  check_scene(home.scene, "home with a person");

  EXPECT_EQ(home.scene.instances[person.instance].kind, InstanceKind::person);
  EXPECT_EQ(home.scene.mesh.triangles.size(), faces + figure.scene.mesh.triangles.size());
  EXPECT_NEAR(euler_from_quaternion(person.world_from_head.orientation).yaw_rad, yaw_rad, 1e-12);
  EXPECT_NEAR(person.world_from_head.position_m.z, figure.mouth_m.z, 1e-12);
  const Vector3 ahead =
      transform_point(person.world_from_head, {1, 0, 0}) - person.world_from_head.position_m;
  EXPECT_NEAR(ahead.x, -0.5, 1e-12);
  // The body's middle is where it was placed.
  Vector3 sum;
  int count = 0;
  for (std::size_t i = faces; i < home.scene.mesh.triangles.size(); ++i) {
    ASSERT_EQ(home.scene.mesh.triangle_instance[i], person.instance);
    ASSERT_EQ(home.scene.materials[home.scene.mesh.triangle_material[i]].acoustic.name, "person");
    sum = sum + vertex(home.scene.mesh, home.scene.mesh.triangles[i][0]);
    ++count;
  }
  // Nose and feet reach 0.1 m ahead of the middle and are few of the vertices.
  EXPECT_NEAR(sum.x / count, 2.0, 0.1);
  EXPECT_NEAR(sum.y / count, 1.5, 0.1);
}

TEST(AddPerson, BringsItsOwnTextures) {
  FigureModel figure = figure_named("a", false);
  figure.scene.textures.emplace_back(2, 2, 3, std::uint8_t{77});
  figure.scene.materials[0].look.texture = 0;
  Home home = make_home(2, {}, FurnitureLibrary());
  const std::size_t textures = home.scene.textures.size();
  const std::size_t materials = home.scene.materials.size();
  add_person(figure, 2.0, 1.5, 0.0, home.scene);
  add_person(figure, 3.0, 1.5, 0.0, home.scene);
  check_scene(home.scene, "home with twins");
  EXPECT_EQ(home.scene.textures.size(), textures + 2);
  EXPECT_EQ(home.scene.materials[materials].look.texture, static_cast<int>(textures));
}

}  // namespace
}  // namespace earpoint
