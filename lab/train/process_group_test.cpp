#include <map>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <earpoint/error.h>
#include <earpoint/train/process_group.h>

namespace earpoint {
namespace {

/// A free port of this machine.
std::uint16_t free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  auto* any = reinterpret_cast<sockaddr*>(&address);
  EXPECT_EQ(::bind(socket, any, size), 0);
  EXPECT_EQ(::getsockname(socket, any, &size), 0);
  ::close(socket);
  return ntohs(address.sin_port);
}

/// Runs members of a group, each on a thread of its own in place of a process.
void run_members(int count, const std::function<void(ProcessGroup&)>& member) {
  const std::uint16_t port = free_port();
  std::vector<std::thread> threads;
  for (int rank = 0; rank < count; ++rank) {
    threads.emplace_back([=, &member] {
      ProcessPlace place;
      place.rank = rank;
      place.processes = place.local_processes = count;
      place.port = port;
      ProcessGroup group(place, 60.0, 60.0);
      EXPECT_EQ(group.rank(), rank);
      EXPECT_EQ(group.size(), count);
      member(group);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(ProcessGroup, SumsOverAllAndGivesTheFirstOnesBytesToAll) {
  run_members(3, [](ProcessGroup& group) {
    std::vector<float> values(1000);
    std::iota(values.begin(), values.end(), 100.0F * static_cast<float>(group.rank()));
    group.sum(std::span(values));
    for (std::size_t i = 0; i < values.size(); ++i) {
      ASSERT_EQ(values[i], 300.0F + 3.0F * static_cast<float>(i));
    }
    double one = 1.0 + group.rank();
    group.sum(std::span(&one, 1));
    EXPECT_EQ(one, 6.0);

    const std::vector<std::byte> own(group.is_first() ? 5 : 2,
                                     group.is_first() ? std::byte{7} : std::byte{1});
    EXPECT_EQ(group.from_first(own), std::vector<std::byte>(5, std::byte{7}));
    EXPECT_TRUE(group.from_first({}).empty());
  });
}

TEST(ProcessGroup, ALostMemberIsAnError) {
  run_members(2, [](ProcessGroup& group) {
    if (!group.is_first()) return;
    double one = 1.0;
    EXPECT_THROW(group.sum(std::span(&one, 1)), InputError);
  });
}

TEST(ProcessGroup, DoesNotWaitForEverForOthersToCome) {
  ProcessPlace place;
  place.processes = place.local_processes = 2;
  place.port = free_port();
  try {
    const ProcessGroup alone(place, 1.0);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("process 0 of 2 cannot meet the others"),
              std::string::npos)
        << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

std::optional<ProcessPlace> place_in(const std::map<std::string, std::string>& variables) {
  return process_place([&](const std::string& name) -> std::optional<std::string> {
    const auto found = variables.find(name);
    if (found == variables.end()) return std::nullopt;
    return found->second;
  });
}

TEST(ProcessPlace, IsReadFromLaunchers) {
  EXPECT_FALSE(place_in({}).has_value());
  EXPECT_FALSE(place_in({{"WORLD_SIZE", "1"}, {"RANK", "0"}}).has_value());

  const auto torchrun = place_in({{"WORLD_SIZE", "4"},
                                  {"RANK", "3"},
                                  {"LOCAL_WORLD_SIZE", "2"},
                                  {"MASTER_ADDR", "10.0.0.7"},
                                  {"MASTER_PORT", "4242"},
                                  {"TORCHELASTIC_USE_AGENT_STORE", "True"},
                                  {"TORCHELASTIC_RESTART_COUNT", "1"}});
  ASSERT_TRUE(torchrun.has_value());
  EXPECT_EQ(torchrun->rank, 3);
  EXPECT_EQ(torchrun->processes, 4);
  EXPECT_EQ(torchrun->local_processes, 2);
  EXPECT_EQ(torchrun->address, "10.0.0.7");
  EXPECT_EQ(torchrun->port, 4242);
  EXPECT_TRUE(torchrun->is_kept_by_launcher);
  EXPECT_EQ(torchrun->key_prefix, "/worker/attempt_1");

  // All on one machine: no address is needed.
  const auto mpi = place_in({{"OMPI_COMM_WORLD_SIZE", "2"},
                             {"OMPI_COMM_WORLD_RANK", "1"},
                             {"OMPI_COMM_WORLD_LOCAL_SIZE", "2"}});
  ASSERT_TRUE(mpi.has_value());
  EXPECT_EQ(mpi->rank, 1);
  EXPECT_EQ(mpi->address, "127.0.0.1");
  EXPECT_EQ(mpi->port, 29500);
  EXPECT_FALSE(mpi->is_kept_by_launcher);

  const auto srun = place_in(
      {{"SLURM_STEP_NUM_TASKS", "3"}, {"SLURM_PROCID", "2"}, {"SLURM_STEP_NUM_NODES", "1"}});
  ASSERT_TRUE(srun.has_value());
  EXPECT_EQ(srun->rank, 2);
  EXPECT_EQ(srun->local_processes, 3);
  // The shell of a batch script is a single process.
  EXPECT_FALSE(place_in({{"SLURM_NTASKS", "3"}, {"SLURM_PROCID", "0"}}).has_value());
}

TEST(ProcessPlace, WhatIsMissingOrMalformedIsNamed) {
  const auto problem = [](const std::map<std::string, std::string>& variables) -> std::string {
    try {
      static_cast<void>(place_in(variables));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(problem({{"WORLD_SIZE", "2"}}).find("RANK: is not set"), std::string::npos);
  EXPECT_NE(problem({{"WORLD_SIZE", "2"}, {"RANK", "2"}}).find("expected 0 to 1, found '2'"),
            std::string::npos);
  EXPECT_NE(problem({{"WORLD_SIZE", "two"}}).find("WORLD_SIZE"), std::string::npos);
  EXPECT_NE(problem({{"PMI_SIZE", "2"}, {"PMI_RANK", "0"}}).find("MASTER_ADDR: is not set"),
            std::string::npos);
}

}  // namespace
}  // namespace earpoint
