#include <earpoint/study/study_server.h>

#include "study_page_bytes.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <httplib.h>

#include <earpoint/core/file.h>
#include <earpoint/serve/page_server.h>
#include <earpoint/study/study_desk.h>

namespace earpoint {
namespace {

constexpr std::size_t kMostBody = 16384;  // of a request, bytes

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

}  // namespace

struct StudyServer::State {
  State(const std::filesystem::path& folder, const PageAddress& address)
      : desk(folder), server({.address = address, .most_body = kMostBody}) {
    route();
  }

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
    server.route_page(study_page_files::page_bytes());
  }

  static std::size_t step_of(const httplib::Request& request) {
    return std::stoul(request.matches[2]);
  }

  StudyDesk desk;
  PageServer server;
};

StudyServer::StudyServer(const std::filesystem::path& folder, const PageAddress& address)
    : state_(std::make_unique<State>(folder, address)) {}
StudyServer::~StudyServer() = default;

int StudyServer::bind() { return state_->server.bind(); }

void StudyServer::run() { state_->server.run(); }

void StudyServer::stop() { state_->server.stop(); }

bool has_study_page() { return !study_page_files::page_bytes().empty(); }

}  // namespace earpoint
