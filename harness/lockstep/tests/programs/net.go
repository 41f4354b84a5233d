// Imports `net`, which loads the C library where there is a C compiler: it asks it for an address, looks for CAN interfaces,
// answers what comes on a serial line, and tells every 20 ms what it has.
package main

import (
	"fmt"
	"net"
	"os"
	"time"
)

func main() {
	port, err := os.OpenFile(os.Args[1], os.O_RDWR, 0)
	if err != nil {
		fmt.Fprintln(os.Stderr, err)
		os.Exit(3)
	}
	addresses, err := net.LookupHost("127.0.0.1")
	fmt.Fprintln(port, addresses, err)
	for _, name := range os.Args[2:] {
		found, err := net.InterfaceByName(name)
		fmt.Fprintln(port, found, err)
		if err == nil {
			again, err := net.InterfaceByIndex(found.Index)
			addresses, _ := again.Addrs()
			fmt.Fprintln(port, again.Name, err, addresses)
		}
	}
	all, err := net.Interfaces()
	for _, one := range all {
		if one.Name == "lo" || one.Name[:3] == "can" {
			fmt.Fprintln(port, one.Name, one.Flags, err)
		}
	}
	start := time.Now()
	came := make(chan string)
	go func() {
		for {
			var text [64]byte
			count, err := port.Read(text[:])
			if err != nil {
				return
			}
			came <- string(text[:count])
		}
	}()
	tick := time.NewTicker(20 * time.Millisecond)
	for {
		select {
		case text := <-came:
			fmt.Fprintf(port, "came %q %d\n", text, time.Since(start).Nanoseconds())
		case <-tick.C:
			fmt.Fprintln(port, "tick", time.Since(start).Nanoseconds())
		}
	}
}
