#include "timed_stream.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

namespace earpoint {
namespace {

using namespace std::chrono_literals;

/// Both ends of a connection.
class Connection {
 public:
  Connection() { EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends_.data()), 0); }
  ~Connection() {
    for (const int end : ends_) close(end);
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  [[nodiscard]] int server() const { return ends_[0]; }
  [[nodiscard]] int client() const { return ends_[1]; }
  void say(const std::string& text) const {
    EXPECT_EQ(send(client(), text.data(), text.size(), MSG_NOSIGNAL), std::ssize(text));
  }

 private:
  std::array<int, 2> ends_{};
};

bool never() { return false; }

/// Reads until the stream gives up. @return the bytes that came before
std::size_t read_all(TimedStream& stream) {
  std::size_t bytes = 0;
  std::array<char, 256> block;
  for (;;) {
    const ssize_t count = stream.read(block.data(), block.size());
    if (count <= 0) return bytes;
    bytes += static_cast<std::size_t>(count);
  }
}

/// Does something every five milliseconds until it is destroyed.
class Drip {
 public:
  template <typename Action>
  explicit Drip(Action action)
      : thread_([this, action] {
          while (!is_done_) {
            action();
            std::this_thread::sleep_for(5ms);
          }
        }) {}
  ~Drip() {
    is_done_ = true;
    thread_.join();
  }
  Drip(const Drip&) = delete;
  Drip& operator=(const Drip&) = delete;

 private:
  std::atomic<bool> is_done_ = false;
  std::thread thread_;
};

TEST(TimedStream, GivesUpOnARequestThatDrips) {
  const Connection connection;
  TimedStream stream(connection.server(), {.silence = 10s, .grace = 100ms}, never);
  const Drip drip([&] { connection.say("G"); });
  EXPECT_TRUE(stream.wait_for_request(10s));
  // The next byte always comes soon; without a deadline this would not end.
  EXPECT_GT(read_all(stream), 0U);
}

TEST(TimedStream, GivesUpOnSilence) {
  const Connection connection;
  TimedStream stream(connection.server(), {.silence = 50ms, .grace = 100s}, never);
  connection.say("GET / HTTP/1.1\r\n");
  EXPECT_TRUE(stream.wait_for_request(10s));
  EXPECT_EQ(read_all(stream), 16U);
}

TEST(TimedStream, WaitsForWhoeverIsFastEnough) {
  const Connection connection;
  // Half a second in all, five times the grace. At 10 kB/s every part adds a second, so that a busy
  // machine may be late.
  TimedStream stream(connection.server(),
                     {.silence = 10s, .grace = 100ms, .least_bytes_per_s = 1e4}, never);
  EXPECT_FALSE(stream.wait_for_request(1ms));
  const std::string part(10'000, 'x');
  connection.say(part);
  EXPECT_TRUE(stream.wait_for_request(10s));
  stream.begin_body();
  std::thread client([&] {
    for (int i = 1; i < 100; ++i) {
      std::this_thread::sleep_for(5ms);
      connection.say(part);
    }
    shutdown(connection.client(), SHUT_WR);
  });
  EXPECT_EQ(read_all(stream), 100U * part.size());
  client.join();
}

TEST(TimedStream, TakesSoManyHeadersAndNoMore) {
  const Connection connection;
  TimedStream stream(connection.server(), {.most_header_bytes = 10'000}, never);
  connection.say(std::string(100'000, 'h'));
  EXPECT_TRUE(stream.wait_for_request(10s));
  const std::size_t bytes = read_all(stream);
  EXPECT_GE(bytes, 10'000U);
  EXPECT_LT(bytes, 20'000U);
}

TEST(TimedStream, GivesUpOnAReaderThatDrips) {
  const Connection connection;
  TimedStream stream(connection.server(),
                     {.silence = 10s, .grace = 100ms, .least_bytes_per_s = 1e8}, never);
  const Drip drip([&] {
    std::array<char, 64> block;
    (void)recv(connection.client(), block.data(), block.size(), MSG_DONTWAIT);
  });
  // More than the system buffers for the reader.
  const std::string answer(16'000'000, 'x');
  EXPECT_LT(stream.write(answer.data(), answer.size()), 0);
}

TEST(TimedStream, SendsAllToWhoeverReads) {
  const Connection connection;
  TimedStream stream(connection.server(), {}, never);
  std::size_t received = 0;
  std::thread client([&] {
    std::array<char, 4096> block;
    for (ssize_t count = 1; count > 0;) {
      count = recv(connection.client(), block.data(), block.size(), 0);
      received += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
    }
  });
  const std::string answer(3'000'000, 'x');
  EXPECT_EQ(stream.write(answer.data(), answer.size()), std::ssize(answer));
  shutdown(connection.server(), SHUT_WR);
  client.join();
  EXPECT_EQ(received, answer.size());
}

TEST(TimedStream, EndsWithTheServer) {
  const Connection connection;
  std::atomic<bool> is_over = false;
  TimedStream stream(connection.server(), {.silence = 100s, .grace = 100s},
                     [&] { return is_over.load(); });
  std::thread server([&] { EXPECT_FALSE(stream.wait_for_request(100s)); });
  is_over = true;
  server.join();
}

}  // namespace
}  // namespace earpoint
