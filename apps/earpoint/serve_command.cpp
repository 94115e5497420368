#include "serve_command.h"

#include "page_options.h"
#include "served_dataset.h"
#include "served_earpoints.h"
#include "served_upload.h"
#include "source_arguments.h"
#include "speaker_search.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/serve/clip_server.h>

namespace earpoint {
namespace {

constexpr const char* kFooter = R"(
Examples:
  # walk through a clip in the browser
  earpoint serve clip.mp4

  # a recording without a picture, the speaker two metres ahead, at a fixed port
  earpoint serve sound.flac --speaker 2,0,0 --port 8080

  # the test clips of a data set, with the true sound at other viewpoints
  earpoint serve --data data/homes
  earpoint serve --data data/recorded

  # a clip with the true sound at other positions
  earpoint serve --earpoints examples/earpoints.json

  # a network of your own beside the shipped ones
  earpoint serve clip.mp4 --model runs/mine/best.safetensors

If this program was built with the engine for browsers, gtf, dsp and the recording are rendered in the
browser, and the rest by this program; ?engine=server or ?engine=browser in the address forces either.

Only this computer can open the page, unless --host is given; the address then contains a token that
listeners need. Stop with Ctrl-C.)";

struct ServeArguments {
  SourceArguments source;
  std::string data;
  std::string earpoints;
  std::string split = "test";
  std::vector<std::string> methods;  ///< empty: what is shipped
  std::vector<std::string> models;   ///< beside them
  std::string detector;              ///< empty: the shipped one
  PageAddress address;
  int listeners = 8;
  bool no_uploads = false;
  bool quiet = false;
};

std::vector<ListenMethod> methods_of(const ServeArguments& arguments) {
  std::vector<std::string> words =
      arguments.methods.empty() ? default_listen_words() : arguments.methods;
  for (const std::string& model : arguments.models) {
    // runs/mine/best.safetensors is called mine.
    const std::filesystem::path path(model);
    std::string name = path.stem().string();
    if (name == "best" && path.has_parent_path()) name = path.parent_path().filename().string();
    words.push_back(fmt::format("{}={}", name, model));
  }
  return listen_methods(words);
}

const GtfWeights* finder_of(const std::vector<ListenMethod>& methods) {
  const auto found = std::ranges::find_if(methods, [](const ListenMethod& m) {
    return m.gtf != nullptr && m.gtf->description.geometry;
  });
  return found == methods.end() ? nullptr : found->gtf.get();
}

/// Opened before anything is served: a bad recording ends the command in a line.
void add_opened(ClipLibrary& library, const std::string& id, ServedClip opened, bool quiet) {
  auto clip = std::make_shared<const ServedClip>(std::move(opened));
  for (const std::string& warning : clip->warnings) {
    if (!quiet) fmt::print(stderr, "earpoint: {}: {}\n", clip->name, warning);
  }
  library.add(id, clip->name, [clip] { return *clip; });
}

void fill(ClipLibrary& library, const ServeArguments& arguments, const GtfWeights* finder) {
  const bool quiet = arguments.quiet;
  if (!arguments.source.inputs.empty()) {
    add_opened(library, "clip", open_recording(arguments.source, finder, arguments.detector, quiet),
               quiet);
  }
  if (!arguments.earpoints.empty()) {
    add_opened(library, "earpoints",
               open_earpoints(arguments.earpoints, finder, arguments.detector, quiet), quiet);
  }
  if (!arguments.data.empty()) add_dataset(arguments.data, arguments.split, library);
}

void check(const ServeArguments& arguments) {
  if (!has_page()) {
    throw InputError("serve", "this build has no page",
                     "install esbuild and build again (./dev build does both)");
  }
  const bool names_none =
      arguments.source.inputs.empty() && arguments.data.empty() && arguments.earpoints.empty();
  if (names_none && arguments.no_uploads) {
    throw InputError("serve", "there is nothing to listen to",
                     "give a clip, --earpoints or --data");
  }
}

void run_serve(const ServeArguments& arguments) {
  check(arguments);
  const std::vector<ListenMethod> methods = methods_of(arguments);
  const GtfWeights* const finder = finder_of(methods);
  ClipLibrary library;
  fill(library, arguments, finder);
  ServeOptions options{.address = with_token(arguments.address),
                       .most_listeners = arguments.listeners};
  if (!arguments.no_uploads) {
    options.open_upload = [&](const std::filesystem::path& file, const std::string& name) {
      return open_upload(file, name, finder, arguments.detector);
    };
  }
  ClipServer server(library, methods, options);
  serve_page(server, options.address, "Listen at");
}

void add_source_options(CLI::App& command, ServeArguments& arguments) {
  add_source_inputs(command, arguments.source)->required(false)->expected(0, 2);
  command.add_option(
      "--data", arguments.data,
      "A data set, of earpoint simulate or record prepare or published, whose clips can be "
      "chosen on the page");
  command.add_option("--earpoints", arguments.earpoints,
                     "A clip with the true sound at other positions, in the format of "
                     "examples/earpoints.json");
  command.add_option("--split", arguments.split, "Split of the data set")->capture_default_str();
  command
      .add_option("--speaker", arguments.source.speaker,
                  "x,y,z of the speaker's mouth in metres, if it is known")
      ->group("Speaker");
  add_box_options(command, arguments.source);
  add_detector_option(command, arguments.detector);
  add_channel_option(command, arguments.source);
  add_recording_option(command, arguments.source);
}

}  // namespace

void add_serve_command(CLI::App& app) {
  auto arguments = std::make_shared<ServeArguments>();
  CLI::App* command =
      app.add_subcommand("serve", "Serve a page to walk through a clip and listen.");
  command->footer(kFooter);
  add_source_options(*command, *arguments);
  command
      ->add_option(
          "--methods", arguments->methods,
          "Methods to compare: input, dsp, names of shipped models, or NAME=FILE; default: all "
          "that are available")
      ->delimiter(',');
  command->add_option("--model", arguments->models, "A further weight file; once per file")
      ->allow_extra_args(false);
  add_page_options(*command, arguments->address);
  command
      ->add_option("--listeners", arguments->listeners,
                   "Maximum number of pages that this program renders for at once")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->add_flag("--no-uploads", arguments->no_uploads,
                    "Do not accept recordings dropped on the page");
  command->add_flag("--quiet", arguments->quiet, "No progress");
  command->callback([arguments] { run_serve(*arguments); });
}

}  // namespace earpoint
