#include <earpoint/generate/people_pictures.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/camera/scene_drawer.h>
#include <earpoint/core/file.h>
#include <earpoint/dataset/people_pictures.h>
#include <earpoint/error.h>
#include <earpoint/generate/conversation.h>
#include <earpoint/media/image_file.h>
#include <earpoint/scene/homes.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kMostPeople = 4;
constexpr double kPersonRadius_m = 0.3;
constexpr double kGroupRadius_m = 3.0;
constexpr double kCameraReach_m = 6.5;
constexpr double kNearestCamera_m = 0.6;
constexpr int kTries = 60;
// A person with a smaller visible share is no target for detection.
constexpr double kLeastVisible = 0.15;
constexpr double kLeastPixelShare = 0.001;  // of the picture
constexpr std::size_t kValFigures = 6;      // every sixth

struct PlacedPerson {
  Person person;
  FloorPoint at;
  std::unique_ptr<Scene> alone;
  std::unique_ptr<RayCaster> caster;  // of `alone`
};

/// The figures that may appear in pictures of a split.
std::vector<const FigureModel*> figures_of(const FigureLibrary& library, std::string_view split) {
  std::vector<const FigureModel*> found;
  std::size_t others = 0;
  for (const FigureModel& figure : library.models()) {
    const bool is_val = !figure.for_test && others++ % kValFigures == kValFigures - 1;
    const std::string_view of = figure.for_test ? "test" : is_val ? "val" : "train";
    if (of == split) found.push_back(&figure);
  }
  return found;
}

const FigureModel& draw_figure(const FigureLibrary& library,
                               const std::vector<const FigureModel*>& figures,
                               RandomStream& random) {
  if (!figures.empty()) return *figures[random.index(figures.size())];
  const Gender gender = random.uniform() < 0.5 ? Gender::female : Gender::male;
  const std::array postures{Posture::standing, Posture::sitting, Posture::ground};
  return library.draw(gender, postures.at(random.index(postures.size())), FigureSplit::train,
                      random);
}

/// Puts people on the free floor, the first anywhere and the others around the first.
std::vector<PlacedPerson> place_people(const PreparedScene& home, const FigureLibrary& library,
                                       const std::vector<const FigureModel*>& figures,
                                       RandomStream& random, Scene& scene) {
  std::vector<PlacedPerson> people;
  const std::size_t count = 1 + random.index(kMostPeople);
  for (int attempt = 0; attempt < kTries && people.size() < count; ++attempt) {
    const auto at = home.floor.draw(kPersonRadius_m, random);
    if (!at) break;
    const bool fits = std::ranges::all_of(people, [&](const PlacedPerson& other) {
      return distance_m(*at, other.at) > 2 * kPersonRadius_m;
    });
    if (!fits || (!people.empty() && distance_m(*at, people[0].at) > kGroupRadius_m)) continue;
    const FigureModel figure = varied_figure(draw_figure(library, figures, random), random);
    const double yaw_rad = random.uniform(-kPi, kPi);
    PlacedPerson& placed = people.emplace_back();
    placed.person = add_person(figure, at->x, at->y, yaw_rad, scene);
    placed.at = *at;
    placed.alone = std::make_unique<Scene>();
    add_person(figure, at->x, at->y, yaw_rad, *placed.alone);
    placed.caster = std::make_unique<RayCaster>(placed.alone->mesh);
  }
  return people;
}

/// A camera that looks at someone, past them, or somewhere else.
std::optional<Camera> draw_camera(const PreparedScene& home,
                                  const std::vector<PlacedPerson>& people,
                                  const PeoplePictureOptions& options, RandomStream& random) {
  const PlacedPerson& whom = people[random.index(people.size())];
  const std::vector<FloorPoint> near = home.floor.within_walk(whom.at, kCameraReach_m);
  if (near.empty()) return std::nullopt;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    const FloorPoint at = near[random.index(near.size())];
    const bool is_free = std::ranges::all_of(people, [&](const PlacedPerson& person) {
      return distance_m(at, person.at) > kNearestCamera_m;
    });
    if (!is_free || home.floor.clearance_m(at) < 0.1) continue;
    Camera camera{.width = options.width, .height = options.height};
    camera.horizontal_fov_rad = radians_from_degrees(random.uniform(45.0, 100.0));
    const double height_m = random.uniform(0.7, 2.1);
    const bool looks_away = random.uniform() < 0.1;
    const double aim_rad = std::atan2(whom.at.y - at.y, whom.at.x - at.x);
    const double yaw_rad =
        looks_away ? random.uniform(-kPi, kPi)
                   : aim_rad + 0.35 * camera.horizontal_fov_rad * random.uniform(-1.0, 1.0);
    // Half of the cameras are nearly level; the others look up or down at the person.
    const double body_m = random.uniform(0.4, 1.1) * whom.person.world_from_head.position_m.z;
    const double slope_rad = std::atan2(body_m - height_m, distance_m(at, whom.at));
    const double pitch_rad =
        (random.uniform() < 0.5 ? 0.0 : slope_rad) + radians_from_degrees(5.0 * random.normal());
    const double roll_rad = radians_from_degrees(2.0 * random.normal());
    camera.world_from_camera = {
        {at.x, at.y, height_m},
        quaternion_from_euler({.yaw_rad = yaw_rad, .pitch_rad = pitch_rad, .roll_rad = roll_rad})};
    if (!looks_away && !sees(home.caster, camera.world_from_camera.position_m,
                             whom.person.world_from_head.position_m)) {
      continue;
    }
    return camera;
  }
  return std::nullopt;
}

/// Number of pixels that would show the person in an empty scene.
int pixels_alone(const PlacedPerson& person, const Camera& camera) {
  int pixels = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vector3 direction = rotate(camera.world_from_camera.orientation,
                                       direction_of_pixel(camera, {x + 0.5, y + 0.5}));
      pixels += person.caster->distance_m(camera.world_from_camera.position_m,
                                          direction / norm(direction))
                    ? 1
                    : 0;
    }
  }
  return pixels;
}

std::vector<LabelledPerson> labels_of(const View& view, const Camera& camera,
                                      const std::vector<PlacedPerson>& people) {
  std::vector<LabelledPerson> labels;
  const auto all = static_cast<double>(view.instance.pixels().size());
  const int least = std::max(1, static_cast<int>(kLeastPixelShare * all));
  for (const PlacedPerson& person : people) {
    const auto instance = static_cast<std::int32_t>(person.person.instance);
    const auto box = visible_box(view, instance, least);
    if (!box) continue;
    const auto seen = std::ranges::count(view.instance.pixels(), instance);
    const double visible =
        std::min(1.0, static_cast<double>(seen) / std::max(1, pixels_alone(person, camera)));
    if (visible < kLeastVisible) continue;
    labels.push_back({*box, visible});
  }
  return labels;
}

void draw_home(const PeoplePictureOptions& options, const FurnitureLibrary& furniture,
               const FigureLibrary& library, const std::string& split, int number,
               const fs::path& folder) {
  RandomStream random(options.seed, {static_cast<std::uint64_t>(number)});
  const auto home =
      prepare_home(folder.filename().string(), make_home(random.next(), {}, furniture).scene);
  const std::vector<const FigureModel*> figures = figures_of(library, split);
  create_folder(folder);
  ThreadPool pool(1);
  std::vector<PeoplePicture> pictures;
  for (int group = 0; group < options.groups; ++group) {
    Scene scene = home->scene;
    const auto people = place_people(*home, library, figures, random, scene);
    if (people.empty()) break;
    const SceneDrawer drawer = home->drawer.extended(scene, pool);
    for (int v = 0; v < options.views; ++v) {
      const auto camera = draw_camera(*home, people, options, random);
      const auto exposure = static_cast<float>(std::exp(random.uniform(-0.5, 0.5)));
      const std::uint64_t noise = random.next();
      if (!camera) continue;
      const View view =
          drawer.draw(*camera, {.samples_per_side = 1, .exposure = exposure}, noise, pool);
      const fs::path file = folder / fmt::format("{:02}-{}.jpg", group, v);
      write_image(file, view.rgb);
      pictures.push_back({file, labels_of(view, *camera, people)});
    }
  }
  write_file(folder / kPeoplePictureList, people_picture_list(pictures));
}

}  // namespace

void draw_people_pictures(const PeoplePictureOptions& options, const FurnitureLibrary& furniture,
                          const FigureLibrary& figures,
                          const std::function<void(int done, int all)>& on_home) {
  const int all = options.train_homes + options.val_homes + options.test_homes;
  EARPOINT_CHECK(options.jobs > 0 && options.groups > 0 && options.views > 0);
  std::mutex mutex;
  int done = 0;
  ThreadPool pool(options.jobs);
  pool.run(all, [&](std::ptrdiff_t task, int) {
    const int number = static_cast<int>(task);
    const std::string split = number < options.train_homes                       ? "train"
                              : number < options.train_homes + options.val_homes ? "val"
                                                                                 : "test";
    const fs::path folder = options.out / split / fmt::format("home-{:04}", number);
    const bool is_wanted = !options.split || *options.split == split;
    if (is_wanted && !fs::exists(folder / kPeoplePictureList)) {
      draw_home(options, furniture, figures, split, number, folder);
    }
    const std::lock_guard lock(mutex);
    on_home(++done, all);
  });
}

}  // namespace earpoint
