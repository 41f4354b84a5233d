// A controller in Go: a gyro on a serial line, and a base on another that is told something every 20 ms. Each line has a
// goroutine; what has come is looked at by one that selects.
package main

import (
	"bufio"
	"fmt"
	"os"
	"strconv"
	"time"
)

func port(path string) *os.File {
	file, err := os.OpenFile(path, os.O_RDWR, 0)
	if err != nil {
		fmt.Fprintln(os.Stderr, err)
		os.Exit(3)
	}
	return file
}

func main() {
	gyro, base := port(os.Args[1]), port(os.Args[2])
	samples := make(chan float64)
	go func() {
		lines := bufio.NewScanner(gyro)
		for lines.Scan() {
			rate, err := strconv.ParseFloat(lines.Text(), 64)
			if err != nil {
				os.Exit(4)
			}
			samples <- rate
		}
	}()
	texts := make(chan string, 16)
	go func() {
		for text := range texts {
			if _, err := base.WriteString(text); err != nil {
				os.Exit(5)
			}
		}
	}()
	start, ticker := time.Now(), time.NewTicker(20*time.Millisecond)
	// The order of a map and the choice of a select are drawn by lot, and have to be the same each time.
	counts := map[string]int{"samples": 0, "ticks": 0, "silences": 0, "rest": 0}
	heading := 0.0
	for {
		select {
		case rate := <-samples:
			heading += rate / 100
			counts["samples"]++
		case <-ticker.C:
			counts["ticks"]++
			order := ""
			for name := range counts {
				order += name[:2]
			}
			texts <- fmt.Sprintf("%d %d %.4f %d %s\n", counts["ticks"], counts["samples"], heading, time.Since(start).Nanoseconds(), order)
		case <-time.After(7 * time.Millisecond):
			counts["silences"]++
			if counts["silences"]%100 == 0 {
				texts <- fmt.Sprintf("silence %d\n", counts["silences"])
			}
		}
	}
}
