#include "timed_stream.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <poll.h>
#include <sys/socket.h>

namespace earpoint {
namespace {

constexpr std::chrono::milliseconds kLook{250};  // for the end of the server

}  // namespace

TimedStream::Clock::time_point TimedStream::end_of(const Way& way) const {
  const std::chrono::duration<double> earned(static_cast<double>(way.bytes) /
                                             limits_.least_bytes_per_s);
  const auto longest =
      way.began + limits_.grace + std::chrono::duration_cast<Clock::duration>(earned);
  return std::min(longest, Clock::now() + limits_.silence);
}

bool TimedStream::wait(short event, Clock::time_point end) const {
  while (!is_over_()) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
    if (left.count() <= 0) return false;
    pollfd on{.fd = socket_, .events = event, .revents = 0};
    const int ready = ::poll(&on, 1, static_cast<int>(std::min(left, kLook).count()));
    if (ready > 0) return (on.revents & (event | POLLHUP)) != 0;
    if (ready < 0 && errno != EINTR) return false;
  }
  return false;
}

bool TimedStream::wait_for_request(std::chrono::milliseconds longest) {
  if (begin_ == end_ && !wait(POLLIN, Clock::now() + longest)) return false;
  is_in_headers_ = true;
  is_answering_ = false;
  received_ = {};
  return true;
}

bool TimedStream::is_readable() const { return begin_ < end_ || wait(POLLIN, end_of(received_)); }

bool TimedStream::is_writable() const { return wait(POLLOUT, Clock::now() + limits_.silence); }

ssize_t TimedStream::read(char* bytes, std::size_t size) {
  if (begin_ == end_) {
    if (is_in_headers_ && received_.bytes > limits_.most_header_bytes) return -1;
    if (!wait(POLLIN, end_of(received_))) return -1;
    const ssize_t count = ::recv(socket_, buffer_.data(), buffer_.size(), 0);
    if (count <= 0) return count;
    begin_ = 0;
    end_ = static_cast<std::size_t>(count);
    received_.bytes += end_;
  }
  const std::size_t count = std::min(size, end_ - begin_);
  std::memcpy(bytes, buffer_.data() + begin_, count);
  begin_ += count;
  return static_cast<ssize_t>(count);
}

ssize_t TimedStream::write(const char* bytes, std::size_t size) {
  // The time spent on making the answer does not count against the client.
  if (!is_answering_) sent_ = {};
  is_answering_ = true;
  std::size_t done = 0;
  while (done < size) {
    if (!wait(POLLOUT, end_of(sent_))) return -1;
    const ssize_t count = ::send(socket_, bytes + done, size - done, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && errno != EAGAIN && errno != EINTR) return -1;
    if (count <= 0) continue;
    done += static_cast<std::size_t>(count);
    sent_.bytes += static_cast<std::size_t>(count);
  }
  return static_cast<ssize_t>(size);
}

void TimedStream::get_remote_ip_and_port(std::string& ip, int& port) const {
  ip.clear();
  port = 0;
}

void TimedStream::get_local_ip_and_port(std::string& ip, int& port) const {
  ip.clear();
  port = 0;
}

}  // namespace earpoint
