#include <earpoint/scene/furniture.h>

#include "stand_ins.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr std::array<std::string_view, kFurnitureKinds> kNames = {
    "sofa",         "armchair",     "coffee table",  "tv stand",        "television",
    "bookcase",     "shelf",        "rug",           "floor lamp",      "table lamp",
    "ceiling lamp", "plant",        "piano",         "dining table",    "chair",
    "stool",        "bed",          "bedside table", "wardrobe",        "dresser",
    "desk",         "office chair", "computer",      "kitchen base",    "kitchen sink",
    "stove",        "fridge",       "wall cabinet",  "washing machine", "bathtub",
    "toilet",       "washbasin",    "towel rack",    "radiator",        "curtain",
    "blinds",       "picture",      "mirror"};

template <std::size_t N>
ScreenColour drawn(const std::array<ScreenColour, N>& colours, RandomStream& random) {
  ScreenColour colour = colours[random.index(N)];
  for (float& part : colour) part *= static_cast<float>(random.uniform(0.9, 1.1));
  return colour;
}

bool within(const Vector3& size, const Vector3& limit) {
  return size.x <= limit.x && size.y <= limit.y && size.z <= limit.z;
}

/// The surfaces of a model, each stored once per scene however often the model is placed.
std::vector<Surface> model_surfaces(const FurnitureModel& model, SceneBuilder& builder) {
  std::vector<Surface> surfaces;
  for (std::size_t i = 0; i < model.scene.materials.size(); ++i) {
    const std::string key = "model:" + model.name + ":" + std::to_string(i);
    Surface surface;
    if (!builder.find_surface(key, surface)) {
      Material material = model.scene.materials[i];
      if (material.look.texture != Look::kNoTexture) {
        const std::string texture_key =
            "texture:" + model.name + ":" + std::to_string(material.look.texture);
        // A texture that several materials share is stored once for each, which is rare and small.
        material.look.texture = builder.add_texture(
            model.scene.textures[static_cast<std::size_t>(material.look.texture)]);
      }
      surface = builder.add_surface(key, material);
    }
    surfaces.push_back(surface);
  }
  return surfaces;
}

}  // namespace

std::string_view name_of(FurnitureKind kind) { return kNames[static_cast<std::size_t>(kind)]; }

std::optional<FurnitureKind> furniture_kind(std::string_view name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<FurnitureKind>(found - kNames.begin());
}

FurnitureStyle draw_furniture_style(RandomStream& random) {
  constexpr std::array<ScreenColour, 6> kWoods = {{{0.78F, 0.62F, 0.42F},
                                                   {0.62F, 0.42F, 0.25F},
                                                   {0.42F, 0.27F, 0.17F},
                                                   {0.88F, 0.80F, 0.66F},
                                                   {0.90F, 0.89F, 0.86F},
                                                   {0.30F, 0.24F, 0.21F}}};
  constexpr std::array<ScreenColour, 7> kFabrics = {{{0.55F, 0.55F, 0.58F},
                                                     {0.30F, 0.36F, 0.46F},
                                                     {0.72F, 0.66F, 0.55F},
                                                     {0.45F, 0.30F, 0.24F},
                                                     {0.35F, 0.45F, 0.36F},
                                                     {0.62F, 0.27F, 0.25F},
                                                     {0.25F, 0.25F, 0.27F}}};
  constexpr std::array<ScreenColour, 6> kAccents = {{{0.75F, 0.30F, 0.25F},
                                                     {0.85F, 0.62F, 0.22F},
                                                     {0.28F, 0.48F, 0.60F},
                                                     {0.40F, 0.55F, 0.38F},
                                                     {0.55F, 0.38F, 0.55F},
                                                     {0.30F, 0.28F, 0.42F}}};
  constexpr std::array<ScreenColour, 6> kCurtains = {{{0.90F, 0.88F, 0.82F},
                                                      {0.70F, 0.62F, 0.50F},
                                                      {0.50F, 0.56F, 0.66F},
                                                      {0.60F, 0.32F, 0.30F},
                                                      {0.45F, 0.52F, 0.42F},
                                                      {0.40F, 0.38F, 0.42F}}};
  FurnitureStyle style;
  style.seed = random.next();
  style.wood = drawn(kWoods, random);
  style.fabric = drawn(kFabrics, random);
  style.accent = drawn(kAccents, random);
  style.bedding = drawn(kAccents, random);
  style.rug = drawn(kAccents, random);
  style.curtain = drawn(kCurtains, random);
  style.leather = random.uniform() < 0.2;
  constexpr std::array<const char*, 3> kCurtainSounds = {"curtain_light", "curtain_velvet",
                                                         "curtain_heavy"};
  style.curtain_sound = kCurtainSounds[random.index(kCurtainSounds.size())];
  return style;
}

FurnitureLibrary::FurnitureLibrary(std::vector<FurnitureModel> models)
    : models_(std::move(models)) {}

std::vector<const FurnitureModel*> FurnitureLibrary::find(FurnitureKind kind,
                                                          const Vector3& limit_m) const {
  std::vector<const FurnitureModel*> found;
  for (const FurnitureModel& model : models_) {
    if (model.kind == kind && within(model.size_m, limit_m)) found.push_back(&model);
  }
  return found;
}

std::optional<FurniturePiece> draw_furniture(const FurnitureLibrary& library, FurnitureKind kind,
                                             const Vector3& limit_m, std::size_t most_triangles,
                                             RandomStream& random) {
  std::vector<const FurnitureModel*> models = library.find(kind, limit_m);
  std::erase_if(models, [&](const FurnitureModel* model) {
    return model->scene.mesh.triangles.size() > most_triangles;
  });
  const SizeRange range = stand_in_sizes(kind);
  const bool stand_in_fits = within(range.low_m, limit_m);
  // Without this the only model of a kind would be in every room of every home.
  const bool lone = models.size() == 1 && stand_in_fits;
  if (!models.empty() && !(lone && random.uniform() < 0.5)) {
    const FurnitureModel* model = models[random.index(models.size())];
    return FurniturePiece{.kind = kind, .model = model, .size_m = model->size_m};
  }
  if (!stand_in_fits) return std::nullopt;
  const auto draw = [&](double low, double high, double limit) {
    return random.uniform(low, std::max(low, std::min(high, limit)));
  };
  FurniturePiece piece{.kind = kind, .model = nullptr, .size_m = {}};
  piece.size_m.x = draw(range.low_m.x, range.high_m.x, limit_m.x);
  piece.size_m.y = draw(range.low_m.y, range.high_m.y, limit_m.y);
  piece.size_m.z = draw(range.low_m.z, range.high_m.z, limit_m.z);
  return piece;
}

std::uint32_t add_furniture(const FurniturePiece& piece, const FurnitureStyle& style,
                            const Placement& placement, SceneBuilder& builder) {
  const std::string name =
      piece.model != nullptr ? piece.model->name : std::string(name_of(piece.kind));
  const std::uint32_t instance = builder.begin_instance(name, InstanceKind::furniture, placement);
  if (piece.model != nullptr) {
    builder.add_mesh(piece.model->scene.mesh, model_surfaces(*piece.model, builder));
  } else {
    add_stand_in(piece.kind, piece.size_m, style, builder);
  }
  return instance;
}

}  // namespace earpoint
