#include <earpoint/serve/page_server.h>

#include "access.h"
#include "timed_stream.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <utility>

#include <fmt/format.h>
#include <httplib.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

using httplib::Request;
using httplib::Response;

// Every open connection has a thread, busy or not. With more connections than this, others wait.
constexpr int kThreads = 256;
constexpr std::size_t kMostRequests = 1000;  // of a connection
constexpr int kWaiting = 256;                // connections that are not accepted yet
constexpr std::chrono::milliseconds kIdle{5000};

/// httplib's server with limits on the time and the requests of a connection.
class TimedServer : public httplib::Server {
 public:
  explicit TimedServer(const StreamLimits& limits) : limits_(limits) {}

  /// After binding: httplib lets five connections wait, and clients beyond them retry only after a
  /// second or more.
  void let_many_wait() { (void)::listen(svr_sock_, kWaiting); }

 private:
  bool process_and_close_socket(socket_t socket) override {
    TimedStream stream(socket, limits_, [this] { return svr_sock_ == INVALID_SOCKET; });
    bool is_answered = false;
    for (std::size_t left = kMostRequests; left > 0 && stream.wait_for_request(kIdle); --left) {
      bool is_closed = false;
      is_answered =
          process_request(stream, left == 1, is_closed, [&](Request&) { stream.begin_body(); });
      // After malformed headers the start of the next request is unknown.
      if (!is_answered || is_closed || stream.is_in_headers()) break;
    }
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return is_answered;
  }

  StreamLimits limits_;
};

const char* type_of(std::string_view name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  if (name.ends_with(".wasm")) return "application/wasm";
  return "application/octet-stream";
}

/// The address that a browser is redirected to: the same, without the token.
std::string without_token(const std::string& target) {
  std::string rest;
  for (std::size_t at = std::min(target.find('?'), target.size()); at < target.size();) {
    const std::size_t end = std::min(target.find('&', at + 1), target.size());
    const std::string_view pair = std::string_view(target).substr(at + 1, end - at - 1);
    if (!pair.starts_with("token=")) rest += (rest.empty() ? "?" : "&") + std::string(pair);
    at = end;
  }
  return "/" + rest;
}

void answer_failure(Response& response, std::exception_ptr failure) {
  try {
    std::rethrow_exception(std::move(failure));
  } catch (const InputError& error) {
    refuse(response, 500, error.what());
  } catch (...) {
    refuse(response, 500, "internal error of the server");
  }
}

}  // namespace

struct PageServer::State {
  explicit State(PageServerOptions options_in)
      : options(std::move(options_in)),
        access(options.address.host, options.address.token),
        server(options.limits) {
    server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    server.set_payload_max_length(options.most_body);
    server.set_tcp_nodelay(true);
    // httplib would let two servers share a port (SO_REUSEPORT).
    server.set_socket_options([](socket_t socket) {
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    });
    server.set_default_headers(
        {{"Cache-Control", "no-store"},
         {"X-Content-Type-Options", "nosniff"},
         {"Referrer-Policy", "no-referrer"},
         {"Content-Security-Policy",
          fmt::format("default-src 'self'; {}img-src 'self' data:; frame-ancestors 'none'",
                      options.compiles_wasm ? "script-src 'self' 'wasm-unsafe-eval'; " : "")}});
    server.set_pre_routing_handler([this](const Request& request, Response& response) {
      return admit(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                      : httplib::Server::HandlerResponse::Handled;
    });
    server.set_exception_handler(
        [](const Request&, Response& response, std::exception_ptr failure) {
          answer_failure(response, std::move(failure));
        });
  }

  /// Whether the request goes on to its handler.
  bool admit(const Request& request, Response& response) const {
    if (const auto refusal = access.refusal(request)) {
      refuse(response, refusal->status, refusal->why);
      return false;
    }
    if (request.method != "GET" && request.method != "POST" && request.method != "HEAD") {
      refuse(response, 405, "GET and POST are answered");
      return false;
    }
    if (request.is_multipart_form_data()) {
      refuse(response, 415, "send the file itself, not a form");
      return false;
    }
    if (const auto cookie = access.cookie(request); cookie && request.path == "/") {
      response.set_header("Set-Cookie", *cookie);
      response.set_redirect(without_token(request.target));
      return false;
    }
    return true;
  }

  PageServerOptions options;
  Access access;
  TimedServer server;
};

PageServer::PageServer(PageServerOptions options) {
  const PageAddress& address = options.address;
  if (!is_loopback(address.host) && address.token.empty()) {
    throw InputError("host " + address.host, "other computers can reach it, and there is no token");
  }
  state_ = std::make_unique<State>(std::move(options));
}
PageServer::~PageServer() = default;

httplib::Server& PageServer::routes() { return state_->server; }

void PageServer::route_page(std::span<const PageBytes> page) {
  state_->server.Get(".*", [page](const Request& request, Response& response) {
    const std::string name = request.path == "/" ? "/index.html" : request.path;
    for (const PageBytes& file : page) {
      if (fmt::format("/{}", file.name) != name) continue;
      return response.set_content(file.bytes.data(), file.bytes.size(), type_of(name));
    }
    refuse(response, 404, "there is no such page");
  });
}

int PageServer::bind() {
  State& s = *state_;
  const PageAddress& address = s.options.address;
  int port = address.port;
  if (port == 0) {
    port = s.server.bind_to_any_port(address.host);
  } else if (!s.server.bind_to_port(address.host, port)) {
    port = -1;
  }
  if (port < 0) {
    throw InputError(fmt::format("{}:{}", address.host, address.port), "cannot be served",
                     "choose another port; 0 takes any that is free");
  }
  s.server.let_many_wait();
  s.access.set_port(port);
  return port;
}

void PageServer::run() { state_->server.listen_after_bind(); }

void PageServer::stop() { state_->server.stop(); }

std::string url_of(const PageAddress& address) {
  const std::string& host = address.host;
  std::string shown = host;
  std::array<char, 256> name{};
  const bool is_everywhere = host == "0.0.0.0" || host == "::";
  if (is_everywhere && gethostname(name.data(), name.size() - 1) == 0) {
    shown = name.data();
  } else if (host.find(':') != std::string::npos) {
    shown = "[" + host + "]";
  }
  return fmt::format("http://{}:{}/{}", shown, address.port,
                     address.token.empty() ? "" : "?token=" + address.token);
}

void refuse(Response& response, int status, const std::string& why) {
  using nlohmann::json;
  response.status = status;
  // File names from outside need not be UTF-8.
  response.set_content(json{{"error", why}}.dump(-1, ' ', false, json::error_handler_t::replace),
                       "application/json");
}

}  // namespace earpoint
