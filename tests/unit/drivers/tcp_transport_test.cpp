// SPDX-License-Identifier: Apache-2.0
#include "drivers/tcp_transport.hpp"
#include "base/clock.hpp"

#include <gmock/gmock.h>

#include <boost/asio/error.hpp>

namespace lcrig {
namespace {

using boost::asio::error::basic_errors;
using ::testing::HasSubstr;
using ::testing::Not;

// In the shipped service no socket can be made, which Asio reports as an aborted connect.
TEST(ConnectError, OfAServiceThatIsShutInNamesTheDropIn) {
  for (const auto error : {basic_errors::operation_aborted, basic_errors::network_unreachable,
                           basic_errors::no_permission}) {
    const Error said = connect_error("tcp:10.0.0.1:4710", error);
    EXPECT_EQ(said.code, Errc::disconnected);
    EXPECT_THAT(said.what, HasSubstr("tcp:10.0.0.1:4710: "));
    EXPECT_THAT(said.what, HasSubstr("lcrigd-tcp.conf"));
  }
}

TEST(ConnectError, OfAHostThatRefusesAsksForTheProgram) {
  const Error said = connect_error("tcp:10.0.0.1:4710", basic_errors::connection_refused);
  EXPECT_THAT(said.what, HasSubstr("is the program there running?"));
  EXPECT_THAT(said.what, Not(HasSubstr("drop-in")));
}

}  // namespace
}  // namespace lcrig
