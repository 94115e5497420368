#include <earpoint/study/study_server.h>

#include "local_server.h"
#include "study_page_bytes.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/core/file.h>
#include <earpoint/study/study_desk.h>

namespace earpoint {
namespace {

constexpr std::size_t kMostBody = 16384;  // of a request, bytes

const char* type_of(std::string_view name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  return "application/octet-stream";
}

void send(const DeskReply& reply, httplib::Response& response) {
  response.status = reply.status;
  response.set_content(reply.body, "application/json");
}

void send_file(const std::optional<std::filesystem::path>& file, const char* type,
               httplib::Response& response) {
  if (!file) return refuse(response, 404, "there is no such resource");
  const std::vector<std::byte> bytes = read_file(*file);
  response.set_content(reinterpret_cast<const char*>(bytes.data()), bytes.size(), type);
}

void send_page(const std::string& path, httplib::Response& response) {
  const std::string name = path == "/" ? "index.html" : path.substr(1);
  for (const study_page::PageBytes& file : study_page::page_bytes()) {
    if (file.name != name) continue;
    return response.set_content(file.bytes.data(), file.bytes.size(), type_of(name));
  }
  refuse(response, 404, "there is no such page");
}

}  // namespace

struct StudyServer::State {
  explicit State(const std::filesystem::path& folder) : desk(folder), server(kMostBody) { route(); }

  void route() {
    using httplib::Request;
    using httplib::Response;
    httplib::Server& routes = server.routes();
    routes.Get("/api/study",
               [this](const Request&, Response& response) { send(desk.study(), response); });
    routes.Post("/api/participants", [this](const Request& request, Response& response) {
      send(desk.join(request.body), response);
    });
    const std::string participant = "/api/participants/([0-9a-f]{32})";
    const std::string step = participant + "/steps/([0-9]{1,4})";
    routes.Get(participant, [this](const Request& request, Response& response) {
      send(desk.state(request.matches[1]), response);
    });
    routes.Get(step + "/picture", [this](const Request& request, Response& response) {
      send_file(desk.picture_file(request.matches[1], step_of(request)), "image/png", response);
    });
    routes.Get(
        step + "/sounds/([a-z0-9]{1,9})", [this](const Request& request, Response& response) {
          send_file(desk.sound_file(request.matches[1], step_of(request), request.matches[3]),
                    "audio/wav", response);
        });
    routes.Post(step, [this](const Request& request, Response& response) {
      send(desk.answer(request.matches[1], step_of(request), request.body), response);
    });
    routes.Post(participant + "/finish", [this](const Request& request, Response& response) {
      send(desk.finish(request.matches[1], request.body), response);
    });
    routes.Get(".*", [](const Request& request, Response& response) {
      send_page(request.path, response);
    });
  }

  static std::size_t step_of(const httplib::Request& request) {
    return std::stoul(request.matches[2]);
  }

  StudyDesk desk;
  LocalServer server;
};

StudyServer::StudyServer(const std::filesystem::path& folder)
    : state_(std::make_unique<State>(folder)) {}
StudyServer::~StudyServer() = default;

int StudyServer::bind(int port) { return state_->server.bind(port); }

void StudyServer::run() { state_->server.run(); }

void StudyServer::stop() { state_->server.stop(); }

bool has_study_page() { return !study_page::page_bytes().empty(); }

}  // namespace earpoint
