// SPDX-License-Identifier: Apache-2.0
#include "base/port_url.hpp"

#include <gtest/gtest.h>

namespace lcrig {
namespace {

TEST(PortUrl, ReadsEveryKind) {
  const auto path = parse_port_url("serial:/dev/ttyUSB0");
  ASSERT_TRUE(path);
  EXPECT_EQ(path->kind, PortKind::path);
  EXPECT_EQ(path->path, "/dev/ttyUSB0");

  const auto bare = parse_port_url("/dev/rig/lcr");
  ASSERT_TRUE(bare);
  EXPECT_EQ(bare->kind, PortKind::path);

  const auto usb = parse_port_url("serial:2184:005f:GWAIHMULA");
  ASSERT_TRUE(usb);
  EXPECT_EQ(usb->kind, PortKind::usb);
  EXPECT_EQ(usb->usb_vendor, 0x2184);
  EXPECT_EQ(usb->usb_product, 0x005f);
  EXPECT_EQ(usb->usb_serial, "GWAIHMULA");
  EXPECT_EQ(parse_port_url("serial:2184:005F")->usb_serial, "");

  const auto pty = parse_port_url("pty:/dev/pts/4");
  ASSERT_TRUE(pty);
  EXPECT_EQ(pty->kind, PortKind::pty);
}

TEST(PortUrl, ReadsTcpInBothForms) {
  for (const char* url : {"tcp:10.0.0.7:4711", "tcp://10.0.0.7:4711", "tcp://10.0.0.7:4711/"}) {
    const auto tcp = parse_port_url(url);
    ASSERT_TRUE(tcp) << url;
    EXPECT_EQ(tcp->kind, PortKind::tcp);
    EXPECT_EQ(tcp->host, "10.0.0.7");
    EXPECT_EQ(tcp->tcp_port, 4711);
  }
  EXPECT_EQ(parse_port_url("tcp://[::1]:80")->host, "::1");
}

TEST(PortUrl, RefusesWhatIsNotAPort) {
  for (const char* url : {"",
                          "serial:",
                          "serial:ttyUSB0",
                          "serial:2184",
                          "serial:2184:",
                          "serial:2184:5f",
                          "serial:2184:005f:",
                          "serial:xyzw:005f",
                          "serial:12184:005f",
                          "pty:",
                          "pty:4",
                          "tcp:",
                          "tcp:host",
                          "tcp:host:",
                          "tcp:host:0",
                          "tcp:host:65536",
                          "tcp:host:-1",
                          "tcp::80",
                          "tcp:::1:80",
                          "tcp:ho st:80",
                          "usb:1",
                          "COM3",
                          "serial:/dev/tty\nX"}) {
    const auto r = parse_port_url(url);
    ASSERT_FALSE(r) << url;
    EXPECT_EQ(r.error().code, Errc::invalid_request) << url;
    EXPECT_NE(r.error().what.find("port \""), std::string::npos) << r.error().what;
  }
}

}  // namespace
}  // namespace lcrig
