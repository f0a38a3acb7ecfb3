// SPDX-License-Identifier: Apache-2.0
// Uses the real clock, because the kernel decides when the bytes of a pty arrive.
#include "drivers/port.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>

#include "drivers/fd_transport.hpp"
#include "tests/support/meter_bench.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

struct Pty {
  Pty() : master(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    ::grantpt(master);
    ::unlockpt(master);
    slave = ::ptsname(master);
  }
  int master;
  std::string slave;
};

struct Ports : ::testing::Test {
  Result<std::unique_ptr<Transport>> open(std::string url) {
    return run_task(io, open_port(std::move(url), SerialSettings(), clock));
  }
  asio::io_context io;
  RealClock clock;
};

TEST_F(Ports, APtyIsDrivenLikeAPortAndItsLossIsNoticed) {
  Pty pty;
  auto master = std::make_unique<FdTransport>(io.get_executor(), clock, pty.master, "master");
  lcr6100::Lcr6100Sim sim(std::move(master), clock, lcr6100::SimConfig(),
                          lcr6100::Lcr6100Sim::Source(support::seven_picofarad));
  auto port = open("pty:" + pty.slave);
  ASSERT_TRUE(port) << port.error().what;
  asio::co_spawn(io, sim.run(), asio::detached);
  lcr6100::Lcr6100 meter(std::move(*port), clock);
  const auto id = run_task(io, meter.identify());
  ASSERT_TRUE(id) << id.error().what;
  EXPECT_EQ(id->model, "LCR-6100");

  sim.close();
  const MonoTime begin = clock.now();
  const auto lost = run_task(io, meter.resync());
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, Errc::disconnected) << lost.error().what;
  EXPECT_LT(clock.now() - begin, 1s);
}

Task<Result<Reply>> ask_while_closing(ScpiLink& link, Transport& master, Clock& clock) {
  const auto executor = co_await asio::this_coro::executor;
  asio::co_spawn(
      executor,
      [&master, &clock]() -> Task<> {
        co_await clock.wait_for(20ms);
        master.close();
      },
      asio::detached);
  auto reply = co_await link.query("*TRG", 30s);
  co_return reply;
}

TEST_F(Ports, AMasterThatClosesInTheMiddleOfAnExchangeIsDisconnectedAtOnce) {
  Pty pty;
  FdTransport master(io.get_executor(), clock, pty.master, "master");
  auto port = open(pty.slave);
  ASSERT_TRUE(port) << port.error().what;
  ScpiLink link(std::move(*port), clock);
  const MonoTime begin = clock.now();
  const auto reply = run_task(io, ask_while_closing(link, master, clock));
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().code, Errc::disconnected) << reply.error().what;
  EXPECT_LT(clock.now() - begin, 5s);
}

TEST_F(Ports, ABarePathToAPtyIsOpenedAsOneAndAgainAfterClosing) {
  Pty pty;
  for (const std::string& url :
       {std::string(pty.slave), "serial:" + pty.slave, "pty:" + pty.slave}) {
    const auto port = open(url);
    ASSERT_TRUE(port) << port.error().what;
    EXPECT_EQ((*port)->name(), "pty:" + pty.slave);
  }
  ::close(pty.master);
}

TEST_F(Ports, APortInUseIsBusy) {
  Pty pty;
  const auto first = open(pty.slave);
  ASSERT_TRUE(first);
  const auto second = open(pty.slave);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::busy);
  EXPECT_NE(second.error().what.find("another program"), std::string::npos);
  ::close(pty.master);
}

TEST_F(Ports, AMissingPortIsDisconnectedAndTheOthersAreListed) {
  for (const char* url : {"serial:/dev/ttyLCRIG7", "pty:/dev/pts/99999", "serial:ffff:fffe:NONE"}) {
    const auto port = open(url);
    ASSERT_FALSE(port) << url;
    EXPECT_EQ(port.error().code, Errc::disconnected) << port.error().what;
    const bool lists = port.error().what.find("ports that exist") != std::string::npos ||
                       port.error().what.find("no serial port exists") != std::string::npos;
    EXPECT_TRUE(lists) << port.error().what;
  }
}

TEST_F(Ports, AFileIsNoPort) {
  for (const char* url : {"pty:/dev/null", "serial:/dev/null", "serial:/etc/passwd"}) {
    const auto port = open(url);
    ASSERT_FALSE(port) << url;
    EXPECT_EQ(port.error().code, Errc::invalid_request) << port.error().what;
  }
}

TEST_F(Ports, TcpConnectsAndARefusalIsNoTimeOut) {
  asio::ip::tcp::acceptor acceptor(io,
                                   asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), 0));
  const std::string url = "tcp://127.0.0.1:" + std::to_string(acceptor.local_endpoint().port());
  {
    const auto port = open(url);
    ASSERT_TRUE(port) << port.error().what;
    asio::ip::tcp::socket peer(io);
    acceptor.accept(peer);
    ASSERT_TRUE(run_task(io, (*port)->write_all("HELLO\n", clock.now() + 1s)));
    std::array<char, 6> got{};
    asio::read(peer, asio::buffer(got));
    EXPECT_EQ(std::string(got.data(), got.size()), "HELLO\n");
  }
  acceptor.close();
  const auto refused = open(url);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::disconnected) << refused.error().what;
}

}  // namespace
}  // namespace lcrig
