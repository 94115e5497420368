#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace httplib {
class Server;
struct Response;
}  // namespace httplib

namespace earpoint {

/// A file of a page, as the build has put it into the program (cmake/EmbedFiles.cmake).
struct PageBytes {
  std::string_view name;
  std::string_view bytes;
};

/// Limits for slow clients; beyond them the connection is closed.
struct StreamLimits {
  std::chrono::milliseconds silence{5000};  ///< the longest time without a byte
  /// Time before `least_bytes_per_s` applies, per request and per answer.
  std::chrono::milliseconds grace{10000};
  double least_bytes_per_s = 16384.0;
  std::size_t most_header_bytes = 65536;
};

/// Where a page is served, and to whom.
struct PageAddress {
  std::string host = "127.0.0.1";
  int port = 0;         ///< 0: any that is free
  std::string token{};  ///< what every request must bring; empty: this computer alone is answered
};

struct PageServerOptions {
  PageAddress address{};
  std::size_t most_body = 16384;  ///< of a request, bytes
  StreamLimits limits{};
  bool compiles_wasm = false;  ///< the page may compile WebAssembly, and still no text
};

/// An HTTP server for the pages of this program and what they ask for. It answers only who may ask
/// (the host's name, the origin, the token), takes nothing but GET, HEAD and POST, and closes
/// connections slower than StreamLimits, so that slow clients cannot occupy its threads.
class PageServer {
 public:
  /// @throws InputError if the host is not this computer alone and there is no token
  explicit PageServer(PageServerOptions options);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  /// Where routes are added, before run(). What a handler throws is answered with status 500.
  [[nodiscard]] httplib::Server& routes();

  /// Answers GET of anything that no route before this takes with a file of the page; "/" is its
  /// index.html. @param page  must outlive this
  void route_page(std::span<const PageBytes> page);

  /// @return the port
  /// @throws InputError if the address cannot be had
  int bind();
  /// Serves until stop(); after bind().
  void run();
  /// From any thread.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Whether an address to listen at is reached from this computer alone.
[[nodiscard]] bool is_loopback(std::string_view host);

/// The address at which a browser finds the page, with the token if there is one. Where the server
/// listens at every network of this computer (0.0.0.0 or ::), it is that of the computer's name.
[[nodiscard]] std::string url_of(const PageAddress& address);

/// Answers with {"error": why}.
void refuse(httplib::Response& response, int status, const std::string& why);

}  // namespace earpoint
