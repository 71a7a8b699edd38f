// SPDX-License-Identifier: MIT
// A CAN interface of Linux, through a raw socket.
// Source: Linux, Documentation/networking/can.rst, chapters 4.1 "RAW protocol sockets" and 6.
#pragma once

#include <string>

#include "linux/can/can_bus.hpp"
#include "linux/system/file_descriptor.hpp"
#include "linux/system/reopened.hpp"

struct can_frame;

namespace flotilla::target {

/// Other programs on this machine receive the frames that this object sends (candump works); the
/// object itself does not.
///
/// After a bus-off nothing is sent until the kernel has sent or dropped all our frames, so no new
/// command queues behind old ones. The socket stays open, because the kernel would keep a closed
/// socket's frames and deliver them to a new socket as another node's.
class SocketCanBus final : public CanBus {
 public:
  SocketCanBus(std::string interface, std::uint8_t node);

  void send(std::span<const link::CanFrame> frames) override;
  bool receive(link::CanFrame& frame) override;
  int descriptor() const override { return socket_ ? socket_->get() : -1; }
  void reopen() override;
  void maintain() override;
  bool usable() const override;
  std::string fault() const override;

 private:
  /// The bus becomes usable with the first maintain() after a recovery. Frames that the controller
  /// received before its bus-off may arrive after the report of the bus-off, so a frame proves a
  /// recovery only after the next maintain().
  enum class Controller { kOn, kOff, kStillOff, kRecovered };

  int open(FileDescriptor& fresh) const;  ///< 0 or errno
  bool take();
  void close();
  bool running(bool before);
  bool write(const link::CanFrame& frame);
  bool flushed();
  void on_error_frame(const ::can_frame& frame);
  void on_failure(int error);

  std::string interface_;
  std::uint8_t node_;
  Reopened<FileDescriptor> socket_;
  bool running_ = false;   ///< the interface is up and its controller active
  bool flushing_ = false;  ///< the kernel may still hold frames from before a bus-off
  Controller controller_ = Controller::kOn;
};

}  // namespace flotilla::target
