#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/scene/material_table.h>

namespace earpoint {
namespace {

std::string refusal(const std::string& json) {
  try {
    MaterialTable::parse(json, "mine.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

constexpr const char* kSmallTable = R"({
  "format": "earpoint-materials-1", "default": "hard",
  "materials": {
    "hard": {"absorption": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6], "scattering": [0, 0, 0, 0, 0, 0, 0, 1]},
    "soft": {"absorption": [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.9], "scattering": [1, 1, 1, 1, 1, 1],
             "transmission_loss_db": [10, 10, 20, 20, 20, 30], "transmission_source": "a book"}
  },
  "patterns": [{"material": "soft", "words": ["rug", "curtain*", "shower wall"]},
               {"material": "hard", "words": ["wall"]}]
})";

std::string edited(const std::string& from, const std::string& to) {
  std::string text = kSmallTable;
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

TEST(MaterialTable, FillsTheBandsThatATableLeavesOutWithTheNearest) {
  const MaterialTable table = MaterialTable::parse(kSmallTable, "mine.json");
  const AcousticMaterial* hard = table.find("hard");
  ASSERT_NE(hard, nullptr);
  EXPECT_EQ(hard->absorption, (BandArray{0.1F, 0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F, 0.6F}));
  EXPECT_EQ(hard->scattering, (BandArray{0, 0, 0, 0, 0, 0, 0, 1}));
  EXPECT_EQ(table.find("soft")->absorption[7], 0.9F);
}

TEST(MaterialTable, TurnsTransmissionLossIntoAShareOfEnergy) {
  const MaterialTable table = MaterialTable::parse(kSmallTable, "mine.json");
  // pow in float: a few units in the last place.
  EXPECT_FLOAT_EQ(table.find("soft")->transmission[1], 0.1F);
  EXPECT_FLOAT_EQ(table.find("soft")->transmission[4], 0.01F);
  EXPECT_FLOAT_EQ(table.find("soft")->transmission[7], 0.001F);
  EXPECT_EQ(table.find("soft")->source, "a book");
}

TEST(MaterialTable, CutsNamesIntoWords) {
  const MaterialTable table = MaterialTable::parse(kSmallTable, "mine.json");
  for (const char* name : {"rug", "RUG.003", "big_rug-2", "bigRug", "x/Rug"}) {
    EXPECT_EQ(table.match(name).material->name, "soft") << name;
    EXPECT_FALSE(table.match(name).is_default) << name;
  }
  for (const char* name : {"rugby", "shrug", "", "42", "\xff\xfe"}) {
    EXPECT_TRUE(table.match(name).is_default) << name;
  }
}

TEST(MaterialTable, PrefersMoreWordsThenTheFirst) {
  const MaterialTable table = MaterialTable::parse(kSmallTable, "mine.json");
  EXPECT_EQ(table.match("wall").material->name, "hard");
  EXPECT_EQ(table.match("wall_of_shower").material->name, "hard");
  EXPECT_EQ(table.match("shower_wall").material->name, "soft");
  EXPECT_EQ(table.match("rug on wall").material->name, "soft");
  EXPECT_EQ(table.match("Curtains").material->name, "soft");
}

TEST(MaterialTable, RefusesWhatItWouldHaveToGuessNamingTheField) {
  EXPECT_EQ(refusal(kSmallTable), "accepted");
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"{", "mine.json: is not valid JSON"},
      {"[]", "mine.json: expected an object, found []"},
      {edited("\"default\"", "\"defualt\""), "mine.json: defualt: is not known"},
      {edited("\"default\": \"hard\"", "\"default\": \"stone\""),
       "mine.json: default: names 'stone', which is not in 'materials'"},
      {edited("materials-1", "materials-9"),
       "mine.json: format: expected 'earpoint-materials-1', found 'earpoint-materials-9'"},
      {edited("0.1, 0.2", "1.1, 0.2"),
       "mine.json: materials.hard.absorption[0]: expected a number in [0, 1], found 1.1"},
      {edited("0.1, 0.2", "-0.1, 0.2"),
       "mine.json: materials.hard.absorption[0]: expected a number in [0, 1], found -0.1"},
      {edited("0.1, 0.2", "\"x\", 0.2"),
       "mine.json: materials.hard.absorption[0]: expected a number in [0, 1], found \"x\""},
      {edited("0.1, 0.2, ", ""),
       "mine.json: materials.hard.absorption: expected 6, 7 or 8 numbers, found 4"},
      {edited("[10, 10, 20", "[1, 10, 20"),
       "mine.json: materials.soft.transmission_loss_db: transmits 0.794 at 62.5 Hz"},
      {edited("\"rug\"", "\"*\""), "mine.json: patterns[0].words[0]: '*' has a *"},
      {edited("\"rug\"", "\"7\""), "mine.json: patterns[0].words[0]: '7' has no letters"},
      {edited("\"material\": \"soft\"", "\"material\": \"silk\""),
       "mine.json: patterns[0].material: names 'silk'"},
      {edited("\"default\": \"hard\"", "\"default\": \"hard\", \"default\": \"soft\""),
       "mine.json: key 'default' occurs twice"},
      {edited("\"default\": \"hard\"", "\"default\": \"hard\", \"extends\": \"none\""),
       "mine.json: extends: expected 'standard', found 'none'"},
  };
  for (const auto& [text, expected] : cases) {
    const std::string message = refusal(text);
    EXPECT_EQ(message.substr(0, expected.size()), expected);
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
}

TEST(MaterialTable, ExtendsTheStandardTable) {
  const MaterialTable table = MaterialTable::parse(R"({
    "format": "earpoint-materials-1", "extends": "standard",
    "materials": {"marble": {"absorption": [1, 1, 1, 1, 1, 1], "scattering": [0, 0, 0, 0, 0, 0]}},
    "patterns": [{"material": "marble", "words": ["mat"]}]})",
                                                   "mine.json");
  EXPECT_EQ(table.find("marble")->absorption[3], 1.0F);
  EXPECT_EQ(table.find("plaster")->absorption, standard_material("plaster").absorption);
  // A match of one word in this table has priority over two words in the standard one.
  EXPECT_EQ(table.match("bath_mat").material->name, "marble");
  EXPECT_EQ(standard_materials().match("bath_mat").material->name, "carpet_thin");
  EXPECT_EQ(table.match("sofa").material->name, "upholstery_fabric");
  EXPECT_EQ(table.match("qwerty").material->name,
            standard_materials().match("qwerty").material->name);
}

TEST(StandardMaterials, EveryRowNamesItsSources) {
  EXPECT_GE(standard_materials().materials().size(), 30U);
  for (const AcousticMaterial& material : standard_materials().materials()) {
    EXPECT_NE(material.source.find(" | "), std::string::npos) << material.name;
    EXPECT_NE(material.source.find(':'), std::string::npos) << material.name;
  }
}

TEST(StandardMaterials, KnowsTheCategoriesOfMatterport3d) {
  // mpcat40 of Matterport3D, without those that name nothing (void, unlabeled).
  for (const char* name : {"wall",
                           "floor",
                           "chair",
                           "door",
                           "table",
                           "picture",
                           "cabinet",
                           "cushion",
                           "window",
                           "sofa",
                           "bed",
                           "curtain",
                           "chest_of_drawers",
                           "plant",
                           "sink",
                           "stairs",
                           "ceiling",
                           "toilet",
                           "stool",
                           "towel",
                           "mirror",
                           "tv_monitor",
                           "shower",
                           "column",
                           "bathtub",
                           "counter",
                           "fireplace",
                           "lighting",
                           "beam",
                           "railing",
                           "shelving",
                           "blinds",
                           "gym_equipment",
                           "seating",
                           "board_panel",
                           "furniture",
                           "appliances",
                           "clothes",
                           "objects",
                           "misc"}) {
    EXPECT_FALSE(standard_materials().match(name).is_default) << name;
  }
}

TEST(StandardMaterials, KnowsTheCategoriesOfReplica) {
  // Replica's classes, without "undefined", "other-leaf" and single letters.
  for (const char* name : {"backpack",
                           "base-cabinet",
                           "basket",
                           "bathtub",
                           "beam",
                           "beanbag",
                           "bed",
                           "bench",
                           "bike",
                           "bin",
                           "blanket",
                           "blinds",
                           "book",
                           "bottle",
                           "box",
                           "bowl",
                           "camera",
                           "cabinet",
                           "candle",
                           "chair",
                           "chopping-board",
                           "clock",
                           "cloth",
                           "clothing",
                           "coaster",
                           "comforter",
                           "computer-keyboard",
                           "cup",
                           "cushion",
                           "curtain",
                           "ceiling",
                           "cooktop",
                           "countertop",
                           "desk",
                           "desk-organizer",
                           "desktop-computer",
                           "door",
                           "exercise-ball",
                           "faucet",
                           "floor",
                           "handbag",
                           "hair-dryer",
                           "handrail",
                           "indoor-plant",
                           "knife-block",
                           "kitchen-utensil",
                           "lamp",
                           "laptop",
                           "major-appliance",
                           "mat",
                           "microwave",
                           "monitor",
                           "mouse",
                           "nightstand",
                           "pan",
                           "panel",
                           "paper-towel",
                           "phone",
                           "picture",
                           "pillar",
                           "pillow",
                           "pipe",
                           "plant-stand",
                           "plate",
                           "pot",
                           "rack",
                           "refrigerator",
                           "remote-control",
                           "scarf",
                           "sculpture",
                           "shelf",
                           "shoe",
                           "shower-stall",
                           "sink",
                           "small-appliance",
                           "sofa",
                           "stair",
                           "stool",
                           "switch",
                           "table",
                           "table-runner",
                           "tablet",
                           "tissue-paper",
                           "toilet",
                           "toothbrush",
                           "towel",
                           "tv-screen",
                           "tv-stand",
                           "umbrella",
                           "utensil-holder",
                           "vase",
                           "vent",
                           "wall",
                           "wall-cabinet",
                           "wall-plug",
                           "wardrobe",
                           "window",
                           "rug",
                           "logo",
                           "bag",
                           "set-of-clothing"}) {
    EXPECT_FALSE(standard_materials().match(name).is_default) << name;
  }
}

TEST(StandardMaterials, KnowsTheObjectsOfGibson) {
  // The household objects of the Gibson scene graphs (COCO's names).
  for (const char* name :
       {"backpack",     "umbrella",   "handbag",      "tie rack",   "suitcase bag", "sports ball",
        "bottle",       "wine glass", "cup",          "bowl",       "chair",        "couch",
        "potted plant", "bed",        "dining table", "toilet",     "tv",           "laptop",
        "keyboard",     "microwave",  "oven",         "toaster",    "sink",         "refrigerator",
        "book",         "clock",      "vase",         "teddy bear", "hair drier",   "toothbrush"}) {
    EXPECT_FALSE(standard_materials().match(name).is_default) << name;
  }
}

TEST(StandardMaterials, PutsNamesWhereAnEarWould) {
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"Carpet_Grey.001", "carpet_felt"},
      {"kitchenTile", "ceramic_tile"},
      {"tv_stand", "furniture_wood"},
      {"tv_monitor", "glass"},
      {"showerCurtain", "plastic"},
      {"window_curtain", "curtain_light"},
      {"glass_door", "glass"},
      {"kitchen cabinet door", "door_wood"},
      {"LeatherSofa", "upholstery_leather"},
      {"floor_lamp", "plastic"},
      {"wood_floor", "wood_floor"},
      {"acoustic ceiling", "acoustic_ceiling_tile"},
      {"person_02_jacket", "upholstery_fabric"},
      {"Person", "person"},
      {"brick_wall", "brick_open_joints"},
      {"painted_brick", "brick_painted"}};
  for (const auto& [name, material] : expected) {
    EXPECT_EQ(standard_materials().match(name).material->name, material) << name;
  }
}

}  // namespace
}  // namespace earpoint
