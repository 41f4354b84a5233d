// A node on CAN in Go, by raw sockets: it answers each frame from the base, sends one of its own every 50 ms, and says what
// it has counted on a serial line.
package main

import (
	"encoding/binary"
	"fmt"
	"os"
	"syscall"
	"time"
	"unsafe"
)

const (
	afCan      = 29
	canRaw     = 1
	siocgIndex = 0x8933
	solCanRaw  = 101
)

type address struct {
	family uint16
	_      uint16
	index  int32
	_      [16]byte
}

func check(what string, errno syscall.Errno) {
	if errno != 0 {
		fmt.Fprintln(os.Stderr, what, errno)
		os.Exit(3)
	}
}

func open(name string) int {
	fd, err := syscall.Socket(afCan, syscall.SOCK_RAW|syscall.SOCK_NONBLOCK|syscall.SOCK_CLOEXEC, canRaw)
	if err != nil {
		fmt.Fprintln(os.Stderr, err)
		os.Exit(3)
	}
	var request [40]byte
	copy(request[:], name)
	_, _, errno := syscall.Syscall(syscall.SYS_IOCTL, uintptr(fd), siocgIndex, uintptr(unsafe.Pointer(&request)))
	check("index", errno)
	// Only frames of the base.
	filter := [2]uint32{0x181, 0x7ff}
	_, _, errno = syscall.Syscall6(syscall.SYS_SETSOCKOPT, uintptr(fd), solCanRaw, 1, uintptr(unsafe.Pointer(&filter)), 8, 0)
	check("filter", errno)
	to := address{family: afCan, index: int32(binary.LittleEndian.Uint32(request[16:]))}
	_, _, errno = syscall.Syscall(syscall.SYS_BIND, uintptr(fd), uintptr(unsafe.Pointer(&to)), unsafe.Sizeof(to))
	check("bind", errno)
	return fd
}

func frame(id uint32, data []byte) []byte {
	bytes := make([]byte, 16)
	binary.LittleEndian.PutUint32(bytes, id)
	bytes[4] = byte(len(data))
	copy(bytes[8:], data)
	return bytes
}

func main() {
	// The runtime waits for it by epoll.
	bus := os.NewFile(uintptr(open(os.Args[1])), os.Args[1])
	log, err := os.OpenFile(os.Args[2], os.O_RDWR, 0)
	if err != nil {
		os.Exit(3)
	}
	heard := make(chan []byte)
	go func() {
		for {
			bytes := make([]byte, 16)
			if count, err := bus.Read(bytes); err != nil || count != 16 {
				os.Exit(4)
			}
			heard <- bytes
		}
	}()
	ticker, frames, ticks := time.NewTicker(50*time.Millisecond), 0, 0
	for {
		select {
		case bytes := <-heard:
			frames++
			bus.Write(frame(0x201, bytes[8:12]))
		case at := <-ticker.C:
			bus.Write(frame(0x701, []byte{byte(frames)}))
			if ticks++; ticks%200 == 0 {
				fmt.Fprintln(log, ticks, at.UnixNano())
			}
		}
	}
}
