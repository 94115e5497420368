// Packs furniture and figures for procedural homes; ./dev assets runs it.
#include <cstdio>
#include <exception>
#include <string>

#include <fmt/core.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/scene/sweet_home.h>

namespace {

std::string credits_of(const earpoint::ModelPack& pack) {
  std::string text =
      "Models in models.pack, from Debian's sweethome3d-furniture, scaled, simplified and with\n"
      "smaller textures. Each line: model, author; licence.\n\n";
  for (const auto& model : pack.furniture) text += model.name + ", " + model.credit + "\n";
  for (const auto& model : pack.figures) text += model.name + ", " + model.credit + "\n";
  return text;
}

void pack_models(const std::string& libraries, const std::string& list, const std::string& folder) {
  const earpoint::SweetHomeResult result = earpoint::convert_sweet_home(libraries, list);
  earpoint::write_model_pack(result.pack, folder + "/models.pack");
  earpoint::write_file(folder + "/CREDITS.txt", credits_of(result.pack));
  for (const std::string& line : result.left_out) fmt::print("left out {}\n", line);
  fmt::print("packed {} pieces of furniture and {} figures into {}/models.pack\n",
             result.pack.furniture.size(), result.pack.figures.size(), folder);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "usage: earpoint-pack-models LIBRARIES sweet_home.json FOLDER\n");
    return 2;
  }
  try {
    pack_models(argv[1], argv[2], argv[3]);
    return 0;
  } catch (const earpoint::InputError& error) {
    fmt::print(stderr, "earpoint-pack-models: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "earpoint-pack-models: {}\n", error.what());
    return 1;
  }
}
