#include <earpoint/serve/clip_server.h>

#include "clip_json.h"
#include "page_bytes.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <fstream>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <httplib.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/temporary_folder.h>
#include <earpoint/error.h>
#include <earpoint/serve/listener_registry.h>
#include <earpoint/serve/walk_export.h>

namespace earpoint {
namespace {

using httplib::Request;
using httplib::Response;
using nlohmann::json;

constexpr std::size_t kMostBody = 4096;                   // of a request, bytes
constexpr std::size_t kMostWalk = std::size_t{4} << 20U;  // 20 minutes are 1.5 MB
constexpr std::size_t kBlock = 65536;                     // of an answer, bytes sent at once
constexpr std::chrono::seconds kLongestBody{30};
constexpr std::chrono::seconds kLongestUpload{300};
constexpr const char* kOneClip = "/api/clips/([0-9a-z-]{1,64})";
constexpr const char* kOneListener = "/api/listeners/([0-9a-f]{32})";

void answer(Response& response, const json& document) {
  response.set_content(text_of(document), "application/json");
}

/// Left and right samples interleaved, as float32.
std::string interleaved(const Waveform& sound) {
  std::string bytes(static_cast<std::size_t>(sound.samples()) * 2 * sizeof(float), '\0');
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    const std::array<float, 2> pair{sound.channel(0)[i], sound.channel(1)[i]};
    std::memcpy(bytes.data() + static_cast<std::size_t>(i) * sizeof(pair), pair.data(),
                sizeof(pair));
  }
  return bytes;
}

/// Passes the body of a request to `take`, as long as it is neither too large nor too slow.
/// @return whether it arrived completely
bool receive(const httplib::ContentReader& read, std::size_t most, std::chrono::seconds longest,
             const std::function<bool(const char*, std::size_t)>& take) {
  const auto end = std::chrono::steady_clock::now() + longest;
  std::size_t received = 0;
  return read([&](const char* bytes, std::size_t count) {
    received += count;
    return received <= most && std::chrono::steady_clock::now() < end && take(bytes, count);
  });
}

/// Sends a file, which may be removed from disk as soon as this returns.
void send_file(const std::filesystem::path& path, const char* type, Response& response) {
  auto file = std::make_shared<std::ifstream>(path, std::ios::binary);
  const auto size = static_cast<std::size_t>(std::filesystem::file_size(path));
  response.set_content_provider(
      size, type, [file](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        std::array<char, 65536> block;
        file->seekg(static_cast<std::streamoff>(offset));
        file->read(block.data(), static_cast<std::streamsize>(std::min(length, block.size())));
        return file->gcount() > 0 &&
               sink.write(block.data(), static_cast<std::size_t>(file->gcount()));
      });
}

/// Sends memory block by block, without a copy of all of it. @param owner  keeps it until then
void send_bytes(std::span<const std::byte> bytes, const std::shared_ptr<const void>& owner,
                Response& response) {
  response.set_content_provider(
      bytes.size(), "application/octet-stream",
      [bytes, owner](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        return sink.write(reinterpret_cast<const char*>(bytes.data()) + offset,
                          std::min(length, kBlock));
      });
}

}  // namespace

struct ClipServer::State {
  State(ClipLibrary& library_in, std::span<const ListenMethod> methods_in, ServeOptions options_in)
      : library(library_in),
        methods(methods_in),
        options(std::move(options_in)),
        listeners(methods, static_cast<std::size_t>(options.most_listeners)),
        pages({.address = options.address,
               .most_body = options.most_upload_bytes,
               .compiles_wasm = has_engine()}),
        server(pages.routes()) {
    route_engine();
    route_pages();
    route_clips();
    route_listeners();
    // Bodies of other requests would be read into memory before they are refused.
    server.Post(".*", [](const Request&, Response& response, const httplib::ContentReader&) {
      refuse(response, 404, "there is nothing to send to");
    });
  }

  void route_pages() {
    server.Get("/api/clips", [this](const Request&, Response& response) {
      json document{{"clips", json::array()},
                    {"most_upload_bytes", options.open_upload ? options.most_upload_bytes : 0},
                    {"has_engine", has_engine()}};
      for (const auto& [id, name] : library.list()) {
        document["clips"].push_back({{"id", id}, {"name", name}});
      }
      answer(response, document);
    });
    server.Get(kOneClip, [this](const Request& request, Response& response) {
      with_clip(request.matches[1], response,
                [&](const auto& clip) { answer(response, json_of(*clip, methods)); });
    });
    server.Get(std::string(kOneClip) + "/(picture|map)", [this](const Request& request,
                                                                Response& response) {
      with_clip(request.matches[1], response, [&](const auto& clip) {
        static const std::vector<std::byte> none;
        const auto& map = clip->map ? clip->map->png : none;
        const auto& png = request.matches[2] == "map" ? map : clip->picture_png;
        if (png.empty()) return refuse(response, 404, "the clip has no such picture");
        response.set_content(reinterpret_cast<const char*>(png.data()), png.size(), "image/png");
      });
    });
    pages.route_page(page_bytes());
  }

  /// What a page needs that renders by itself.
  void route_engine() {
    server.Get(std::string(kOneClip) + "/sound",
               [this](const Request& request, Response& response) {
                 with_clip(request.matches[1], response, [&](const auto& clip) {
                   send_bytes(std::as_bytes(clip->sound.planar()), clip, response);
                 });
               });
    server.Get("/api/model", [this](const Request& request, Response& response) {
      const auto method =
          std::ranges::find(methods, request.get_param_value("method"), &ListenMethod::name);
      if (method == methods.end() || !method->engine_model) {
        return refuse(response, 404, "there is no method of that name for browsers");
      }
      send_bytes(*method->engine_model, method->engine_model, response);
    });
  }

  void route_clips() {
    server.Post("/api/clips", [this](const Request& request, Response& response,
                                     const httplib::ContentReader& read) {
      take_upload(request, response, read);
    });
    server.Post(std::string(kOneClip) + "/walk",
                [this](const Request& request, Response& response,
                       const httplib::ContentReader& read) { send_walk(request, response, read); });
  }

  void route_listeners() {
    server.Post("/api/listeners",
                [this](const Request&, Response& response, const httplib::ContentReader& read) {
                  const auto body = body_of(read, kMostBody, response);
                  if (body) add_listener(*body, response);
                });
    server.Post(
        std::string(kOneListener) + "/sound",
        [this](const Request& request, Response& response, const httplib::ContentReader& read) {
          const auto body = body_of(read, kMostBody, response);
          if (body) send_sound(request.matches[1], *body, response);
        });
    server.Post(std::string(kOneListener) + "/leave",
                [this](const Request& request, Response& response, const httplib::ContentReader&) {
                  listeners.remove(request.matches[1]);
                  answer(response, json::object());
                });
  }

  static std::optional<std::string> body_of(const httplib::ContentReader& read, std::size_t most,
                                            Response& response) {
    std::string body;
    const bool whole = receive(read, most, kLongestBody, [&](const char* bytes, std::size_t count) {
      body.append(bytes, count);
      return true;
    });
    if (whole) return body;
    refuse(response, 413, "the request is too large or came too slowly");
    return std::nullopt;
  }

  template <typename Use>
  void with_clip(const std::string& id, Response& response, const Use& use) {
    try {
      const auto clip = library.open(id);
      if (!clip) return refuse(response, 404, "there is no such clip");
      use(clip);
    } catch (const InputError& error) {
      refuse(response, 400, error.what());
    }
  }

  void add_listener(const std::string& body, Response& response) {
    const json document = json::parse(body, nullptr, false);
    const bool names_clip =
        document.is_object() && document.contains("clip") && document["clip"].is_string();
    if (!names_clip) return refuse(response, 400, "clip: is not named");
    with_clip(document["clip"].get<std::string>(), response, [&](const auto& clip) {
      const std::string name = listeners.add(clip);
      if (name.empty()) return refuse(response, 503, "too many listeners; close another page");
      answer(response, {{"listener", name}});
    });
  }

  void send_sound(const std::string& name, const std::string& body, Response& response) {
    const auto seat = listeners.find(name);
    if (!seat) return refuse(response, 404, "no such listener; load the page again");
    try {
      const std::lock_guard lock(seat->mutex);
      const SoundRequest request = parse_sound_request(body, seat->listener.clip());
      seat->last_heard = std::chrono::steady_clock::now();
      const Waveform sound = seat->listener.listen(request.start, request.samples, request.wish);
      response.set_content(interleaved(sound), "application/octet-stream");
    } catch (const InputError& error) {
      refuse(response, 400, error.what());
    }
  }

  void send_walk(const Request& request, Response& response, const httplib::ContentReader& read) {
    const auto walk = body_of(read, kMostWalk, response);
    if (!walk) return;
    const std::string name = request.get_param_value("method");
    const auto method = std::ranges::find(methods, name, &ListenMethod::name);
    if (method == methods.end()) {
      return refuse(response, 400,
                    name == kTruthName ? "the true sound is known only at some positions"
                                       : "there is no method of that name");
    }
    const bool is_movie = request.get_param_value("format") == "mp4";
    const std::unique_lock alone(exporting, std::try_to_lock);
    if (!alone.owns_lock())
      return refuse(response, 503, "another walk is being rendered; try again");
    with_clip(request.matches[1], response, [&](const auto& clip) {
      const TemporaryFolder folder;
      const auto output = folder.path() / (is_movie ? "walk.mp4" : "walk.wav");
      export_walk(*clip, *method, *walk, output);
      send_file(output, is_movie ? "video/mp4" : "audio/wav", response);
    });
  }

  void take_upload(const Request& request, Response& response, const httplib::ContentReader& read) {
    if (!options.open_upload) return refuse(response, 403, "this server does not accept files");
    const std::unique_lock alone(uploading, std::try_to_lock);
    if (!alone.owns_lock()) return refuse(response, 503, "another file is being read; try again");
    const TemporaryFolder folder;
    const auto path = folder.path() / "upload";
    std::ofstream file(path, std::ios::binary);
    const bool whole = receive(read, options.most_upload_bytes, kLongestUpload,
                               [&](const char* bytes, std::size_t count) {
                                 file.write(bytes, static_cast<std::streamsize>(count));
                                 return file.good();
                               });
    file.close();
    if (!whole || !file) {
      return refuse(response, 413,
                    fmt::format("the file is incomplete; at most {} MB are accepted",
                                options.most_upload_bytes >> 20U));
    }
    try {
      ServedClip clip = options.open_upload(path, request.get_param_value("name").substr(0, 200));
      answer(response, {{"clip", library.add_private(std::move(clip))}});
    } catch (const InputError& error) {
      refuse(response, 400, error.what());
    }
  }

  ClipLibrary& library;
  std::span<const ListenMethod> methods;
  ServeOptions options;
  ListenerRegistry listeners;
  std::mutex exporting;
  std::mutex uploading;
  PageServer pages;
  httplib::Server& server;
};

ClipServer::ClipServer(ClipLibrary& library, std::span<const ListenMethod> methods,
                       ServeOptions options)
    : state_(std::make_unique<State>(library, methods, std::move(options))) {}
ClipServer::~ClipServer() = default;

int ClipServer::bind() { return state_->pages.bind(); }

void ClipServer::run() { state_->pages.run(); }

void ClipServer::stop() { state_->pages.stop(); }

bool has_page() { return !page_bytes().empty(); }

bool has_engine() {
  const auto files = page_bytes();
  return std::ranges::find(files, kEngineFile, &PageBytes::name) != files.end();
}

}  // namespace earpoint
