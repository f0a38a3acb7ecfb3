// SPDX-License-Identifier: Apache-2.0
#include "drivers/serial_transport.hpp"

#include <fcntl.h>
#include <libserialport.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "base/clock.hpp"
#include "drivers/fd_transport.hpp"

namespace lcrig {

namespace {

struct FreePort {
  void operator()(sp_port* port) const { sp_free_port(port); }
};
using PortHandle = std::unique_ptr<sp_port, FreePort>;

struct FreeList {
  void operator()(sp_port** list) const { sp_free_port_list(list); }
};
using PortList = std::unique_ptr<sp_port*, FreeList>;

PortList list_ports() {
  sp_port** list = nullptr;
  return PortList(sp_list_ports(&list) == SP_OK ? list : nullptr);
}

// libserialport 0.1.1 does not resolve links such as /dev/serial/by-id/....
std::string resolved(const std::string& path) {
  char* real = ::realpath(path.c_str(), nullptr);
  if (real == nullptr) return path;
  std::string out(real);
  std::free(real);
  return out;
}

std::string describe(const sp_port* port) {
  std::string out = sp_get_port_name(port);
  int vendor = 0, product = 0;
  if (sp_get_port_usb_vid_pid(port, &vendor, &product) == SP_OK) {
    const char* serial = sp_get_port_usb_serial(port);
    out += fmt::format(" (usb {:04x}:{:04x}{}{})", vendor, product, serial ? ":" : "",
                       serial ? serial : "");
  }
  return out;
}

std::string existing_ports() {
  const PortList list = list_ports();
  std::string out;
  for (sp_port** p = list.get(); p != nullptr && *p != nullptr; ++p) {
    out += (out.empty() ? "" : ", ") + describe(*p);
  }
  return out.empty() ? "no serial port exists" : "ports that exist: " + out;
}

tl::unexpected<Error> open_failed(const std::string& name, int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO: return fail(Errc::disconnected, "{}: no such port; {}", name, existing_ports());
    case EACCES:
    case EPERM:
      return fail(Errc::io,
                  "{}: no rights to open the port; add the user to the group lcrig (or dialout) "
                  "and log in again",
                  name);
    case EBUSY: return fail(Errc::busy, "{}: another program uses the port; stop it first", name);
    default: return fail(Errc::io, "{}: open: {}", name, std::strerror(error));
  }
}

// TIOCEXCL keeps other users out, but not root. flock keeps out a second daemon that runs as root.
Result<> claim(const std::string& name, int fd) {
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    return errno == EWOULDBLOCK ? open_failed(name, EBUSY) : open_failed(name, errno);
  }
  if (::ioctl(fd, TIOCEXCL) != 0) return open_failed(name, errno);
  return {};
}

Result<PortHandle> find_by_usb(const std::string& name, const PortUrl& url) {
  const PortList list = list_ports();
  for (sp_port** p = list.get(); p != nullptr && *p != nullptr; ++p) {
    int vendor = 0, product = 0;
    if (sp_get_port_usb_vid_pid(*p, &vendor, &product) != SP_OK) continue;
    if (vendor != url.usb_vendor || product != url.usb_product) continue;
    const char* serial = sp_get_port_usb_serial(*p);
    if (!url.usb_serial.empty() && (serial == nullptr || url.usb_serial != serial)) continue;
    sp_port* copy = nullptr;
    if (sp_copy_port(*p, &copy) == SP_OK) return PortHandle(copy);
  }
  return fail(Errc::disconnected, "{}: no USB serial port has this id; {}", name, existing_ports());
}

Result<PortHandle> find_by_path(const std::string& name, const std::string& path) {
  const std::string real = resolved(path);
  if (::access(real.c_str(), F_OK) != 0) return open_failed(name, errno);
  sp_port* port = nullptr;
  if (sp_get_port_by_name(real.c_str(), &port) != SP_OK) {
    return fail(Errc::invalid_request, "{}: not a serial port; {}", name, existing_ports());
  }
  return PortHandle(port);
}

bool configure(sp_port* port, int fd, const SerialSettings& settings) {
  sp_port_config* config = nullptr;
  if (sp_new_config(&config) != SP_OK) return false;
  sp_set_config_baudrate(config, settings.baud);
  sp_set_config_bits(config, 8);
  sp_set_config_parity(config, SP_PARITY_NONE);
  sp_set_config_stopbits(config, 1);
  sp_set_config_flowcontrol(config, SP_FLOWCONTROL_NONE);
  const bool ok = sp_set_config(port, config) == SP_OK;
  sp_free_config(config);
  // libserialport leaves VMIN at 0. Then read() of an idle port returns 0, which looks like end of
  // file.
  termios t{};
  if (!ok || ::tcgetattr(fd, &t) != 0) return false;
  t.c_cc[VMIN] = 1;
  t.c_cc[VTIME] = 0;
  return ::tcsetattr(fd, TCSANOW, &t) == 0 && ::fcntl(fd, F_SETFD, FD_CLOEXEC) == 0;
}

std::string name_of(const PortUrl& url) {
  if (url.kind != PortKind::usb) return "serial:" + url.path;
  const std::string colon = url.usb_serial.empty() ? "" : ":";
  return fmt::format("serial:{:04x}:{:04x}{}{}", url.usb_vendor, url.usb_product, colon,
                     url.usb_serial);
}

}  // namespace

bool is_pty(const std::string& path) {
  return resolved(path).starts_with("/dev/pts/");
}

// A port that still exists is closed on the thread of the instruments, although a line that accepts
// no bytes may block the call. On another thread the port could still be busy when it is opened
// again, and a STOP on its way might not be sent before the frame is made safe.
std::unique_ptr<Transport> OpenedPort::to_transport(asio::any_io_executor executor,
                                                    Clock& clock) && {
  const int fd = std::exchange(fd_, -1);
  return std::make_unique<FdTransport>(std::move(executor), clock, fd, std::move(name_),
                                       std::move(closer_));
}

Result<OpenedPort> open_serial(const PortUrl& url, const SerialSettings& settings) {
  const std::string name = name_of(url);
  auto found = url.kind == PortKind::usb ? find_by_usb(name, url) : find_by_path(name, url.path);
  if (!found) return fail(found.error());
  PortHandle port = std::move(*found);
  errno = 0;
  if (sp_open(port.get(), SP_MODE_READ_WRITE) != SP_OK) {
    return open_failed(name, sp_last_error_code() != 0 ? sp_last_error_code() : EIO);
  }
  int fd = -1;
  if (sp_get_port_handle(port.get(), &fd) != SP_OK) return open_failed(name, EIO);
  Result<> claimed = claim(name, fd);
  if (claimed && !configure(port.get(), fd, settings)) {
    claimed = fail(Errc::io, "{}: the port does not take {} baud 8N1", name, settings.baud);
  }
  if (!claimed) {
    sp_close(port.get());
    return fail(claimed.error());
  }
  sp_port* raw = port.release();
  return OpenedPort(fd, name, [raw](int open_fd) {
    ::ioctl(open_fd, TIOCNXCL);
    sp_close(raw);
    sp_free_port(raw);
  });
}

Result<OpenedPort> open_pty(const std::string& path) {
  const std::string name = "pty:" + path;
  const int fd = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return open_failed(name, errno);
  Result<> ready;
  termios t{};
  if (::tcgetattr(fd, &t) != 0) {
    ready = fail(Errc::invalid_request, "{}: not a terminal", name);
  } else {
    ready = claim(name, fd);
  }
  ::cfmakeraw(&t);
  if (ready && ::tcsetattr(fd, TCSANOW, &t) != 0) ready = open_failed(name, errno);
  if (!ready) {
    ::close(fd);
    return fail(ready.error());
  }
  // A pty lives as long as its other side is open, so the exclusive mark must be removed.
  return OpenedPort(fd, name, [](int open_fd) {
    ::ioctl(open_fd, TIOCNXCL);
    ::close(open_fd);
  });
}

bool is_serial_there(const PortUrl& url) {
  if (url.kind == PortKind::usb) return find_by_usb("", url).has_value();
  return ::access(url.path.c_str(), F_OK) == 0;
}

}  // namespace lcrig
