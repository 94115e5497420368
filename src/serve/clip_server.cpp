#include "page_files.h"

#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <httplib.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/error.h>
#include <earpoint/serve/clip_server.h>
#include <earpoint/serve/listener_registry.h>
#include <earpoint/synth/earpoint_path.h>

namespace earpoint {
namespace {

using nlohmann::json;

constexpr int kThreads = 8;
constexpr std::size_t kMostBody = 4096;  // of a request, bytes
constexpr int kReadTimeout_s = 5;
constexpr int kWriteTimeout_s = 10;

std::string text_of(const json& document) {
  return document.dump(-1, ' ', false, json::error_handler_t::replace);
}

json json_of(const Vector3& p) { return {p.x, p.y, p.z}; }

json json_of(const ServedClip& clip) {
  json document{{"name", clip.name},
                {"duration_s", clip.sound.duration_s()},
                {"sample_rate_hz", clip.sound.sample_rate_hz()},
                {"samples", clip.sound.samples()},
                {"has_picture", clip.picture != nullptr},
                {"fov_deg", degrees_from_radians(clip.horizontal_fov_rad)},
                {"methods", {"input", "gtf"}},
                {"warnings", clip.warnings},
                {"speaker",
                 {{"position_m", json_of(clip.speaker_m.value_or(clip.located.speaker.position_m))},
                  {"told", clip.speaker_m.has_value()},
                  {"heading_deg", degrees_from_radians(clip.located.speaker.yaw_rad)},
                  {"spread_deg", degrees_from_radians(clip.located.azimuth_spread_rad)}}}};
  if (clip.speaker_box) {
    const Box& box = *clip.speaker_box;
    document["box"] = {box.x_min, box.y_min, box.x_max, box.y_max};
  }
  return document;
}

/// What a listener asks for.
struct SoundRequest {
  std::ptrdiff_t start = 0;
  std::ptrdiff_t samples = 0;
  Pose pose;
  ListenMethod method = ListenMethod::gtf;
};

double number_of(const json& document, const char* key, double fallback) {
  const auto found = document.find(key);
  if (found == document.end()) return fallback;
  if (!found->is_number()) throw InputError(key, "is no number");
  return found->get<double>();
}

/// @throws InputError naming the field
SoundRequest parse_request(const std::string& body, const ServedClip& clip) {
  const json document = json::parse(body, nullptr, false);
  if (!document.is_object()) throw InputError("request", "is no JSON object");
  SoundRequest request;
  const double start = number_of(document, "start", 0.0);
  const double samples = number_of(document, "samples", 0.0);
  if (!(start >= 0.0 && start < static_cast<double>(clip.sound.samples()))) {
    throw InputError("start", "lies outside of the clip");
  }
  if (!(samples >= 1.0 && samples <= clip.sound.sample_rate_hz())) {
    throw InputError("samples", "is not between 1 and a second's worth");
  }
  request.start = static_cast<std::ptrdiff_t>(start);
  request.samples = static_cast<std::ptrdiff_t>(samples);
  const json place = document.value("position_m", json::array({0, 0, 0}));
  if (!place.is_array() || place.size() != 3) throw InputError("position_m", "is not [x, y, z]");
  for (const json& coordinate : place) {
    if (!coordinate.is_number()) throw InputError("position_m", "holds what is no number");
  }
  request.pose.position_m = {place[0].get<double>(), place[1].get<double>(),
                             place[2].get<double>()};
  check_place(request.pose.position_m, "position_m");
  const double yaw_deg = number_of(document, "yaw_deg", 0.0);
  const double pitch_deg = number_of(document, "pitch_deg", 0.0);
  check_angle_deg(yaw_deg, "yaw_deg");
  check_angle_deg(pitch_deg, "pitch_deg");
  request.pose.orientation = quaternion_from_euler(
      {.yaw_rad = radians_from_degrees(yaw_deg), .pitch_rad = radians_from_degrees(pitch_deg)});
  const std::optional<ListenMethod> method =
      listen_method(document.contains("method") && document["method"].is_string()
                        ? document["method"].get<std::string>()
                        : "gtf");
  if (!method) throw InputError("method", "is neither input nor gtf");
  request.method = *method;
  return request;
}

/// Left and right in turns, as float32.
std::string interleaved(const Waveform& sound) {
  std::string bytes(static_cast<std::size_t>(sound.samples()) * 2 * sizeof(float), '\0');
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    const std::array<float, 2> pair{sound.channel(0)[i], sound.channel(1)[i]};
    std::memcpy(bytes.data() + static_cast<std::size_t>(i) * sizeof(pair), pair.data(),
                sizeof(pair));
  }
  return bytes;
}

void refuse(httplib::Response& response, int status, const std::string& why) {
  response.status = status;
  response.set_content(text_of({{"error", why}}), "application/json");
}

}  // namespace

struct ClipServer::State {
  State(const ServedClip& clip_in, const ServeOptions& options_in)
      : clip(clip_in),
        options(options_in),
        listeners(clip_in, static_cast<std::size_t>(options_in.most_listeners)) {
    server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    server.set_payload_max_length(kMostBody);
    server.set_read_timeout(kReadTimeout_s, 0);
    server.set_write_timeout(kWriteTimeout_s, 0);
    server.set_tcp_nodelay(true);
    // httplib would let two servers share a port (SO_REUSEPORT).
    server.set_socket_options([](socket_t socket) {
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    });
    server.set_default_headers(
        {{"Cache-Control", "no-store"},
         {"X-Content-Type-Options", "nosniff"},
         {"Content-Security-Policy", "default-src 'self'; img-src 'self' data:"}});
    route();
  }

  void route() {
    server.set_pre_routing_handler(
        [this](const httplib::Request& request, httplib::Response& response) {
          if (names_this_host(request.get_header_value("Host"))) {
            return httplib::Server::HandlerResponse::Unhandled;
          }
          refuse(response, 403, "this server answers to its own address only");
          return httplib::Server::HandlerResponse::Handled;
        });
    server.Get("/api/clip", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(text_of(json_of(clip)), "application/json");
    });
    server.Get("/api/picture", [this](const httplib::Request&, httplib::Response& response) {
      if (clip.picture_png.empty()) return refuse(response, 404, "the clip has no picture");
      response.set_content(reinterpret_cast<const char*>(clip.picture_png.data()),
                           clip.picture_png.size(), "image/png");
    });
    server.Post("/api/listeners", [this](const httplib::Request&, httplib::Response& response) {
      const std::string name = listeners.add();
      if (name.empty()) return refuse(response, 503, "too many listeners; close another page");
      response.set_content(text_of({{"listener", name}}), "application/json");
    });
    server.Post(R"(/api/listeners/([0-9a-f]{32})/sound)",
                [this](const httplib::Request& request, httplib::Response& response) {
                  send_sound(request, response);
                });
    server.Get(".*", [](const httplib::Request& request, httplib::Response& response) {
      const std::optional<PageFile> file = page_file(request.path);
      if (!file) return refuse(response, 404, "there is no such page");
      response.set_content(file->bytes.data(), file->bytes.size(), file->type);
    });
  }

  [[nodiscard]] bool names_this_host(const std::string& host) const {
    for (const char* name : {"localhost", "127.0.0.1", "[::1]", options.host.c_str()}) {
      if (host == name || host == fmt::format("{}:{}", name, port)) return true;
    }
    return false;
  }

  void send_sound(const httplib::Request& request, httplib::Response& response) {
    const auto seat = listeners.find(request.matches[1]);
    if (!seat) return refuse(response, 404, "no such listener; load the page again");
    try {
      const SoundRequest wish = parse_request(request.body, clip);
      const std::lock_guard lock(seat->mutex);
      seat->last_heard = std::chrono::steady_clock::now();
      const Waveform sound =
          seat->listener.listen(wish.start, wish.samples, wish.pose, wish.method);
      response.set_content(interleaved(sound), "application/octet-stream");
    } catch (const InputError& error) {
      refuse(response, 400, error.what());
    }
  }

  const ServedClip& clip;
  ServeOptions options;
  ListenerRegistry listeners;
  httplib::Server server;
  int port = 0;
};

ClipServer::ClipServer(const ServedClip& clip, const ServeOptions& options)
    : state_(std::make_unique<State>(clip, options)) {}
ClipServer::~ClipServer() = default;

int ClipServer::bind() {
  State& s = *state_;
  const auto fail = [&] {
    throw InputError(fmt::format("{}:{}", s.options.host, s.options.port), "cannot be served",
                     "choose another --port; 0 takes any that is free");
  };
  if (s.options.port == 0) {
    s.port = s.server.bind_to_any_port(s.options.host.c_str());
    if (s.port < 0) fail();
  } else {
    if (!s.server.bind_to_port(s.options.host.c_str(), s.options.port)) fail();
    s.port = s.options.port;
  }
  return s.port;
}

void ClipServer::run() { state_->server.listen_after_bind(); }

void ClipServer::stop() { state_->server.stop(); }

}  // namespace earpoint
