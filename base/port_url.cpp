// SPDX-License-Identifier: Apache-2.0
#include "base/port_url.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include "base/text.hpp"

namespace lcrig {

namespace {

bool take_prefix(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

std::optional<std::uint16_t> parse_u16(std::string_view text, int base) {
  std::uint16_t value = 0;
  const auto r = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (r.ec != std::errc() || r.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

// Four hexadecimal digits, the form that lsusb prints.
std::optional<std::uint16_t> parse_usb_id(std::string_view text) {
  return text.size() == 4 ? parse_u16(text, 16) : std::nullopt;
}

bool has_control(std::string_view text) {
  return std::ranges::any_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x20; });
}

Result<PortUrl> parse_path(std::string_view url, std::string_view path, PortKind kind) {
  if (path.empty() || path.front() != '/') {
    return fail(Errc::invalid_request, "port \"{}\": expected an absolute path such as {}",
                printable(url), kind == PortKind::pty ? "/dev/pts/4" : "/dev/ttyUSB0");
  }
  PortUrl out;
  out.kind = kind;
  out.path = path;
  return out;
}

Result<PortUrl> parse_usb(std::string_view url, std::string_view text) {
  const auto first = text.find(':');
  const auto vendor = parse_usb_id(text.substr(0, first));
  std::string_view rest = first == text.npos ? std::string_view() : text.substr(first + 1);
  const auto second = rest.find(':');
  const auto product = parse_usb_id(rest.substr(0, second));
  const bool empty_serial = second != rest.npos && second + 1 == rest.size();
  if (!vendor || !product || empty_serial) {
    return fail(Errc::invalid_request,
                "port \"{}\": expected serial:/dev/NAME, or serial:VID:PID[:SERIAL] with four "
                "hexadecimal digits each, such as serial:2184:005f",
                printable(url));
  }
  PortUrl out;
  out.kind = PortKind::usb;
  out.usb_vendor = *vendor;
  out.usb_product = *product;
  if (second != rest.npos) out.usb_serial = rest.substr(second + 1);
  return out;
}

Result<PortUrl> parse_tcp(std::string_view url, std::string_view text) {
  take_prefix(text, "//");
  if (text.ends_with('/')) text.remove_suffix(1);
  const auto colon = text.rfind(':');
  const std::uint16_t port =
      colon == text.npos ? 0 : parse_u16(text.substr(colon + 1), 10).value_or(0);
  std::string_view host = text.substr(0, colon == text.npos ? 0 : colon);
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  const bool plain = host.find_first_of(":/[] ") == host.npos;
  if (port == 0 || host.empty() || !(bracketed || plain)) {
    return fail(Errc::invalid_request,
                "port \"{}\": expected tcp:HOST:PORT with a port of 1 to 65535, such as "
                "tcp:127.0.0.1:4711 or tcp://[::1]:4711",
                printable(url));
  }
  PortUrl out;
  out.kind = PortKind::tcp;
  out.host = host;
  out.tcp_port = port;
  return out;
}

}  // namespace

Result<PortUrl> parse_port_url(std::string_view url) {
  if (has_control(url) || url.size() > 1024) {
    return fail(Errc::invalid_request, "port \"{}\": control characters, or too long",
                printable(url.substr(0, 80)));
  }
  std::string_view rest = url;
  if (take_prefix(rest, "serial:")) {
    if (rest.starts_with('/')) return parse_path(url, rest, PortKind::path);
    return parse_usb(url, rest);
  }
  if (take_prefix(rest, "pty:")) return parse_path(url, rest, PortKind::pty);
  if (take_prefix(rest, "tcp:")) return parse_tcp(url, rest);
  if (rest.starts_with('/')) return parse_path(url, rest, PortKind::path);
  return fail(Errc::invalid_request,
              "port \"{}\": expected serial:PATH, serial:VID:PID[:SERIAL], pty:PATH, "
              "tcp:HOST:PORT or an absolute path",
              printable(url));
}

}  // namespace lcrig
