#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

#include <httplib.h>

#include <earpoint/serve/page_server.h>

namespace earpoint {

/// One end of a connection for httplib, which gives up on whoever is slow. httplib's own waits for
/// every byte anew: a byte every few seconds would keep a thread forever.
class TimedStream : public httplib::Stream {
 public:
  /// @param is_over  whether the server is about to end
  TimedStream(socket_t socket, const StreamLimits& limits, std::function<bool()> is_over)
      : socket_(socket), limits_(limits), is_over_(std::move(is_over)) {}

  /// Waits for the next request. @return whether there is one
  [[nodiscard]] bool wait_for_request(std::chrono::milliseconds longest);
  /// The headers are there: what follows is the body.
  void begin_body() { is_in_headers_ = false; }
  [[nodiscard]] bool is_in_headers() const { return is_in_headers_; }

  [[nodiscard]] bool is_readable() const override;
  [[nodiscard]] bool is_writable() const override;
  ssize_t read(char* bytes, std::size_t size) override;
  ssize_t write(const char* bytes, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  [[nodiscard]] socket_t socket() const override { return socket_; }

 private:
  using Clock = std::chrono::steady_clock;

  /// How long one way of a request has taken.
  struct Way {
    Clock::time_point began = Clock::now();
    std::size_t bytes = 0;
  };
  [[nodiscard]] Clock::time_point end_of(const Way& way) const;
  [[nodiscard]] bool wait(short event, Clock::time_point end) const;

  socket_t socket_;
  StreamLimits limits_;
  std::function<bool()> is_over_;
  std::array<char, 4096> buffer_{};
  std::size_t begin_ = 0;  ///< of what is in the buffer
  std::size_t end_ = 0;
  bool is_in_headers_ = true;
  bool is_answering_ = false;
  Way received_;
  Way sent_;
};

}  // namespace earpoint
