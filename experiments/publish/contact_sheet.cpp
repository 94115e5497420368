// Draws views of conversations in homes onto one picture.
//
// usage: contact_sheet SHEET.jpg [FIRST_SEED [COLUMNS ROWS [PIXELS]]]

#include "conversation_views.h"

#include <cstdio>
#include <cstdlib>
#include <exception>

#include <earpoint/camera/scene_drawer.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>
#include <earpoint/plot/draw.h>
#include <earpoint/scene/model_pack.h>

namespace {

using namespace earpoint;

int number(int argc, char** argv, int index, int otherwise) {
  return argc > index ? std::atoi(argv[index]) : otherwise;
}

/// One view of a conversation in the home of the first seed, from there on, that has room for it.
View draw_view(std::uint64_t& seed, int pixels, const FurnitureLibrary& furniture,
               const FigureLibrary& figures, ThreadPool& pool) {
  while (true) {
    RandomStream random(seed);
    try {
      const Home home = make_home(seed++, {}, furniture);
      const bench::ConversationViews conversation =
          bench::draw_conversation(home, figures, 1, pixels, pixels, random);
      const SceneDrawer drawer(conversation.scene, {}, pool);
      return drawer.draw(conversation.cameras[0], {}, seed, pool);
    } catch (const InputError& error) {
      std::fprintf(stderr, "contact_sheet: home %d: %s\n", static_cast<int>(seed), error.what());
    }
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) return 2;
  auto seed = static_cast<std::uint64_t>(number(argc, argv, 2, 0));
  const int columns = number(argc, argv, 3, 6);
  const int rows = number(argc, argv, 4, 4);
  const int pixels = number(argc, argv, 5, 256);
  ModelPack pack = installed_models();
  const FurnitureLibrary furniture(std::move(pack.furniture));
  const FigureLibrary figures(std::move(pack.figures));
  ThreadPool pool(available_cores());
  Image sheet = filled_image(columns * pixels, rows * pixels, {});
  for (int i = 0; i < columns * rows; ++i) {
    const View view = draw_view(seed, pixels, furniture, figures, pool);
    paste(sheet, view.rgb, i % columns * pixels, i / columns * pixels);
  }
  write_image(argv[1], sheet);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "contact_sheet: %s\n", error.what());
  return 1;
}
