#include "local_server.h"

#include <exception>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/error.h>

namespace earpoint {
namespace {

constexpr int kThreads = 8;
constexpr int kReadTimeout_s = 5;
constexpr int kWriteTimeout_s = 10;
constexpr const char* kHost = "127.0.0.1";

}  // namespace

void refuse(httplib::Response& response, int status, const std::string& why) {
  response.status = status;
  response.set_content(
      nlohmann::json{{"error", why}}.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
      "application/json");
}

LocalServer::LocalServer(std::size_t most_body) {
  server_.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  server_.set_payload_max_length(most_body);
  server_.set_read_timeout(kReadTimeout_s, 0);
  server_.set_write_timeout(kWriteTimeout_s, 0);
  server_.set_tcp_nodelay(true);
  // httplib would let two servers share a port (SO_REUSEPORT).
  server_.set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  server_.set_default_headers(
      {{"Cache-Control", "no-store"},
       {"X-Content-Type-Options", "nosniff"},
       {"Content-Security-Policy", "default-src 'self'; img-src 'self' data:"}});
  server_.set_exception_handler(
      [](const httplib::Request&, httplib::Response& response, std::exception_ptr error) {
        try {
          std::rethrow_exception(std::move(error));
        } catch (const std::exception& what) {
          refuse(response, 500, what.what());
        }
      });
  server_.set_pre_routing_handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        if (names_this_host(request.get_header_value("Host"))) {
          return httplib::Server::HandlerResponse::Unhandled;
        }
        refuse(response, 403, "this server answers to its own address only");
        return httplib::Server::HandlerResponse::Handled;
      });
}

bool LocalServer::names_this_host(const std::string& host) const {
  for (const char* name : {"localhost", kHost, "[::1]"}) {
    if (host == name || host == fmt::format("{}:{}", name, port_)) return true;
  }
  return false;
}

int LocalServer::bind(int port) {
  port_ = port;
  if (port == 0) {
    port_ = server_.bind_to_any_port(kHost);
  } else if (!server_.bind_to_port(kHost, port)) {
    port_ = -1;
  }
  if (port_ < 0) {
    throw InputError(fmt::format("{}:{}", kHost, port), "cannot be served",
                     "choose another port; 0 takes any that is free");
  }
  return port_;
}

void LocalServer::run() { server_.listen_after_bind(); }

void LocalServer::stop() { server_.stop(); }

}  // namespace earpoint
