// SPDX-License-Identifier: Apache-2.0
#include "drivers/tcp_transport.hpp"
#include "base/clock.hpp"

#include <gmock/gmock.h>

#include <boost/asio/error.hpp>

#include "tests/support/run_task.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using boost::asio::error::basic_errors;
using ::testing::HasSubstr;
using ::testing::Not;

// In the shipped service no socket can be created. Asio reports this as an aborted connect.
TEST(ConnectError, OfAServiceThatIsShutInNamesTheDropIn) {
  for (const auto error : {basic_errors::operation_aborted, basic_errors::network_unreachable,
                           basic_errors::no_permission}) {
    const Error said = connect_error("tcp:10.0.0.1:4710", error);
    EXPECT_EQ(said.code, Errc::disconnected);
    EXPECT_THAT(said.what, HasSubstr("tcp:10.0.0.1:4710: "));
    EXPECT_THAT(said.what, HasSubstr("lcrigd-tcp.conf"));
  }
}

TEST(ConnectError, OfNoSocketSaysNothingOfACancelledOperation) {
  const Error said = connect_error("tcp:10.0.0.1:4710", basic_errors::operation_aborted);
  EXPECT_THAT(said.what, HasSubstr("tcp:10.0.0.1:4710: no socket can be made; "));
  EXPECT_THAT(said.what, Not(HasSubstr("cancel")));
}

// A label of more than 63 characters is refused without asking a name server.
TEST(ConnectError, OfANameThatIsNotFoundNamesTheNumericAddressAndTheDropIn) {
  asio::io_context io;
  RealClock clock;
  const auto opened =
      run_task(io, open_tcp(std::string(70, 'x') + ".lab", 4710, clock, clock.now() + 30s));
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, Errc::disconnected) << "the port is absent, not at fault";
  for (const char* words :
       {"no address was found for this host name", "numeric address", "lcrigd-tcp.conf"}) {
    EXPECT_THAT(opened.error().what, HasSubstr(words));
  }
}

TEST(ConnectError, OfAHostThatRefusesAsksForTheProgram) {
  const Error said = connect_error("tcp:10.0.0.1:4710", basic_errors::connection_refused);
  EXPECT_THAT(said.what, HasSubstr("is the program there running?"));
  EXPECT_THAT(said.what, Not(HasSubstr("drop-in")));
}

}  // namespace
}  // namespace lcrig
