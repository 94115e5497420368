#pragma once

#include <cstddef>
#include <string>

#include <httplib.h>

namespace earpoint {

/// An HTTP server that only this computer reaches, with limits on what a request may take.
class LocalServer {
 public:
  /// @param most_body  of a request, bytes
  explicit LocalServer(std::size_t most_body);

  /// Where routes are added, before run().
  [[nodiscard]] httplib::Server& routes() { return server_; }

  /// @param port  of 127.0.0.1; 0 takes any that is free
  /// @return the port
  /// @throws InputError if it cannot be had
  int bind(int port);
  /// Serves until stop(); after bind().
  void run();
  /// From any thread.
  void stop();

 private:
  [[nodiscard]] bool names_this_host(const std::string& host) const;

  httplib::Server server_;
  int port_ = 0;
};

/// {"error": why}
void refuse(httplib::Response& response, int status, const std::string& why);

}  // namespace earpoint
